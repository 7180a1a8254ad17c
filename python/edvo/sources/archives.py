# SPDX-License-Identifier: MIT
"""Zip archives of what only Python reads, unpacked into the cache of the C++ program."""

from __future__ import annotations

import errno
import os
import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath

from edvo.errors import Error
from edvo.sources.bag_reader import STORAGES
from edvo.sources.folder import cache_folder
from edvo.sources.untrusted import DAMAGE, one_line

PYTHON_FILES = ("rgb.mp4", *(f"*{suffix}" for suffix in (".bag", *STORAGES)))
PYTHON_IMAGES = (".tif", ".tiff", ".exr", ".npy", ".pgm", ".ppm", ".bmp", ".depth")


# Images hardly compress: what grows more is made to fill the disk. As the C++ program has it.
LARGEST_GROWTH, ALWAYS_ALLOWED = 100, 1 << 26  # [bytes]
# Of names in the archive, not of the disk.
BAD_NAMES = (errno.ENAMETOOLONG, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.EINVAL, errno.EILSEQ)


def is_for_python(path: Path) -> bool:
    """A .zip whose files only Python reads, by their names."""
    if path.suffix.lower() != ".zip" or not path.is_file():
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            names = [PurePosixPath(name) for name in archive.namelist()]
    except OSError:
        return False
    except DAMAGE:
        return False  # the C++ library says what is wrong
    names = [name for name in names if "__MACOSX" not in name.parts and name.name[:1] != "."]
    return any(
        any(name.match(pattern) for pattern in PYTHON_FILES)
        or (name.suffix.lower() in PYTHON_IMAGES and len(name.parts) > 1)
        for name in names
    )


def unpack(archive: Path) -> Path:
    """The folder in the cache, unpacked the first time only; `edvo cache` lists and clears it."""
    state = archive.stat()
    cache = cache_folder()
    # Named as the C++ program does: NAME-SIZE-TIME, .partial while it is not whole.
    target = cache / f"{archive.name}-{state.st_size:x}-{state.st_mtime_ns:x}"
    if target.is_dir():
        target.touch()  # its last use: the cache drops what was used longest ago
        return target
    partial = cache / f"{target.name}-{os.urandom(4).hex()}.partial"  # two may unpack at once
    try:
        partial.mkdir(parents=True)
    except OSError as error:
        raise Error(f"{cache}: {error.strerror}; XDG_CACHE_HOME moves the cache", 7) from None
    try:
        extract(archive, partial)
        if not target.is_dir():
            partial.rename(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return target


def extract(archive: Path, folder: Path) -> None:
    """Raises edvo.Error for a damaged archive (3) and where there is no room for it (7)."""
    try:
        with zipfile.ZipFile(archive) as files:
            for name in files.namelist():
                if name.startswith("/") or ".." in PurePosixPath(name).parts:
                    raise Error(f"{archive}: entry {name!r} would be written outside the folder", 3)
            size = sum(entry.file_size for entry in files.infolist())
            packed = archive.stat().st_size
            if size > ALWAYS_ALLOWED and size > LARGEST_GROWTH * packed:
                raise Error(
                    f"{archive}: unpacks to more than {LARGEST_GROWTH} times its size of {packed} bytes", 3
                )
            free = shutil.disk_usage(folder).free
            if size > free:
                raise Error(
                    f"{archive}: unpacked it has {size} bytes, and {folder.parent} has room for "
                    f"{free}; XDG_CACHE_HOME moves the cache",
                    code=7,
                )
            files.extractall(folder)
    except Error:
        raise
    except OSError as error:
        if error.errno in BAD_NAMES:
            raise Error(f"{archive}: an entry cannot be written: {error.strerror}", 3) from None
        raise Error(f"{folder.parent}: {error.strerror}; XDG_CACHE_HOME moves the cache", 7) from None
    except DAMAGE as error:
        raise Error(f"{archive}: damaged, or encrypted: {one_line(error)}", code=3) from None


def places_in(folder: Path) -> Iterator[Path]:
    """Where a recording may be: the folder, what is in it, and what is in its folders."""
    yield folder
    inside = sorted(p for p in folder.iterdir() if p.name[0] != "." and p.name != "__MACOSX")
    yield from inside
    for place in inside:
        if place.is_dir():
            yield from sorted(place.iterdir())


def recording_in(archive: Path, is_one: Callable[[Path], bool]) -> Path:
    """Unpacks it and finds what is a recording; without any the folder, for a message about it."""
    folder = unpack(archive)
    return next((place for place in places_in(folder) if is_one(place)), folder)
