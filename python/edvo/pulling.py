# SPDX-License-Identifier: MIT
"""Downloads into the cache: public sequences and edge networks."""

from __future__ import annotations

import difflib
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from edvo import _core
from edvo.errors import Error
from edvo.sources.folder import cache_folder

MODEL, OUTPUT = 6, 7  # exit statuses
BLOCK = 1 << 14  # [bytes]; at a cut, less than one is lost
TRIES = 3  # of an address that fails on the way
PAUSE = 1.0  # [s], after the first one
TUM = "https://cvg.cit.tum.de/rgbd/dataset"
TUM_NAMES = {  # https://cvg.cit.tum.de/data/datasets/rgbd-dataset/download
    1: "xyz rpy 360 floor desk desk2 room plant teddy",
    2: "xyz rpy 360_hemisphere 360_kidnap desk desk_with_person large_no_loop large_with_loop "
    "pioneer_360 pioneer_slam pioneer_slam2 pioneer_slam3 coke dishes flowerbouquet "
    "flowerbouquet_brownbackground metallic_sphere metallic_sphere2",
    3: "long_office_household cabinet large_cabinet teddy sitting_static sitting_xyz "
    "sitting_halfsphere sitting_rpy walking_static walking_xyz walking_halfsphere walking_rpy "
    "nostructure_notexture_far nostructure_notexture_near_withloop nostructure_texture_far "
    "nostructure_texture_near_withloop structure_notexture_far structure_notexture_near "
    "structure_texture_far structure_texture_near",
}


@dataclass(frozen=True)
class Item:
    """Something that can be pulled."""

    name: str  # "tum/fr1/xyz"
    addresses: tuple[str, ...]  # tried in this order
    licence: str
    sha256: str | None = None  # None = its publisher gives none
    bytes: int | None = None
    is_model: bool = False

    @property
    def file(self) -> Path:
        folder = cache_folder() / ("models" if self.is_model else "sequences")
        return folder / (f"{self.name}.onnx" if self.is_model else self.addresses[0].rsplit("/")[-1])


def known_items() -> dict[str, Item]:
    items = []
    for camera, names in TUM_NAMES.items():
        for name in names.split():
            base = f"{TUM}/freiburg{camera}/rgbd_dataset_freiburg{camera}_{name}.tgz"
            items.append(Item(f"tum/fr{camera}/{name}", (base,), "CC BY 4.0"))
    for model in _core.known_models():
        items.append(
            Item(
                model["name"],
                tuple(model["addresses"]),
                model["licence"],
                model["sha256"],
                model["bytes"],
                is_model=True,
            )
        )
    return {item.name: item for item in items}


def listing() -> list[str]:
    """What is known and whether it is there, one line each."""
    return [
        f"{item.name:<45} {'there' if item.file.exists() else '-':<6} {item.licence}"
        for item in known_items().values()
    ]


def pull(
    name: str, *, url: str | None = None, timeout: float = 30, quiet: bool = False
) -> Path:
    """Downloads what is missing of an item and returns where it is.

    Goes on where a download was cut off. The SHA-256 is checked where it is known; of others the
    first download's is kept beside the file, and what is there must match it. Raises ``edvo.Error``.
    """
    items = known_items()
    if name not in items:
        near = difflib.get_close_matches(name, items, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise Error(f"pull {name}: not known{hint}; `edvo pull --list` shows all", 2)
    item = items[name]
    if is_there(item):
        return description_of(item) if item.is_model else item.file
    failures = []
    for address in (url,) if url else item.addresses:
        try:
            retrieve(item, address, timeout, quiet)
            break
        except Error as error:
            if error.code != MODEL:
                raise
            failures.append(str(error))
    else:
        raise Error("; ".join(failures), MODEL)
    if not item.is_model:
        return item.file
    status = _core.main(["edvo", "models", "import", str(item.file)])
    if status != 0:
        raise Error(f"{item.file}: could not be imported", int(status))
    return description_of(item)


def description_of(item: Item) -> Path:
    return item.file.with_suffix(".toml")


def is_there(item: Item) -> bool:
    if item.is_model:
        return description_of(item).exists() and item.file.exists()
    note = hash_file(item)
    if not item.file.exists() or not note.exists():
        return False
    import pooch

    if pooch.file_hash(str(item.file)) != note.read_text(encoding="ascii", errors="replace").strip():
        raise Error(f"{item.file}: has changed since it was downloaded; remove it to fetch it again", 3)
    return True


def hash_file(item: Item) -> Path:
    return item.file.with_name(item.file.name + ".sha256")


def retrieve(item: Item, address: str, timeout: float, quiet: bool) -> None:
    import pooch

    downloader = Resuming(item, timeout, quiet)
    try:
        item.file.parent.mkdir(parents=True, exist_ok=True)
        pooch.get_logger().setLevel("ERROR")
        pooch.retrieve(
            address,
            known_hash=f"sha256:{item.sha256}" if item.sha256 else None,
            fname=item.file.name,
            path=item.file.parent,
            downloader=downloader,
        )
    except ValueError:  # pooch: the hash differs; the file is not kept
        raise Error(
            f"{address}: not the file that was expected (SHA-256); it was not kept", MODEL
        ) from None
    except OSError as error:
        raise Error(f"{item.file}: cannot be written: {error.strerror or error}", OUTPUT) from None
    if not item.is_model:
        hash_file(item).write_text(pooch.file_hash(str(item.file)) + "\n", encoding="ascii")


class Resuming:
    """A downloader for pooch that goes on where it was cut off.

    What has arrived lies in NAME.part, beside it NAME.part.tag says of which version of the file.
    """

    def __init__(self, item: Item, timeout: float, quiet: bool) -> None:
        self._item = item
        self._timeout = timeout
        self._progress = Progress(quiet)
        self._part = item.file.with_name(item.file.name + ".part")
        self._tag = item.file.with_name(item.file.name + ".part.tag")

    def __call__(self, url: str, output_file: Any, pooch: Any) -> None:
        import requests

        failure = ""
        for attempt in range(TRIES):
            if attempt:
                time.sleep(attempt * PAUSE)
            try:
                if self._fetch(url):
                    self._tag.unlink(missing_ok=True)
                    self._part.replace(output_file)
                    return
                failure = "the connection was cut"
            except requests.HTTPError as error:
                response: Any = error.response
                failure = f"{response.status_code} {response.reason}"
                if response.status_code < 500 and response.status_code not in (408, 429):
                    break
            except requests.Timeout:
                failure = f"no data for {self._timeout:g} s"
            except requests.RequestException as error:
                failure = f"cannot be reached ({type(error).__name__})"
        kept = self._part.stat().st_size if self._part.exists() else 0
        rest = f"; {kept / 1e6:.1f} MB are kept, the same command goes on" if kept else ""
        raise Error(f"{url}: {failure}{rest}", MODEL)

    def _fetch(self, url: str) -> bool:
        """Adds to the part; whether it is complete."""
        import requests

        have = self._part.stat().st_size if self._part.exists() else 0
        tag = self._tag.read_text(encoding="ascii", errors="replace") if self._tag.exists() else ""
        tag = tag if tag.isascii() and tag.isprintable() else ""  # damaged: a header cannot hold it
        headers = {"Accept-Encoding": "identity"}
        if have and tag:
            headers |= {"Range": f"bytes={have}-", "If-Range": tag}
        else:
            have = 0
        with requests.get(url, headers=headers, stream=True, timeout=self._timeout) as answer:
            if answer.status_code == 416:  # the part is longer than the file: begin anew
                self._part.unlink(missing_ok=True)
                return False
            answer.raise_for_status()
            if answer.status_code != 206:
                have = 0
            length = answer.headers.get("Content-Length", "")
            total = have + int(length) if length.isascii() and length.isdecimal() else None
            if self._item.bytes is not None and total not in (None, self._item.bytes):
                raise Error(f"{url}: {total} bytes instead of {self._item.bytes}", MODEL)
            version = answer.headers.get("ETag") or answer.headers.get("Last-Modified") or ""
            self._tag.write_text("" if version.startswith("W/") else version, encoding="utf-8", errors="replace")
            with self._part.open("ab" if have else "wb") as stream:
                for block in blocks(answer):
                    stream.write(block)
                    have += len(block)
                    self._progress.show(have, total)
            self._progress.end()
        return have == total if total is not None else have > 0


def blocks(answer: Any) -> Any:
    """Of an answer; a cut connection ends them, as its length tells."""
    import requests

    try:
        yield from answer.iter_content(BLOCK)
    except requests.exceptions.ChunkedEncodingError:
        return
    except requests.exceptions.ConnectionError as error:
        if "timed out" in str(error):
            raise requests.Timeout() from None


class Progress:
    """One line on a terminal, one per tenth elsewhere; on stderr."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._is_terminal = sys.stderr.isatty()
        self._shown = -1

    def show(self, done: int, total: int | None) -> None:
        share = int(100 * done / total) if total else done // 1_000_000
        step = share if self._is_terminal else share // 10
        if self._quiet or step == self._shown:
            return
        self._shown = step
        text = f"{share:3} % of {total / 1e6:.1f} MB" if total else f"{share} MB"
        before, after = ("\r", "") if self._is_terminal else ("", "\n")
        print(f"{before}{text}", end=after, file=sys.stderr, flush=True)

    def end(self) -> None:
        if not self._quiet and self._is_terminal and self._shown >= 0:
            print(file=sys.stderr)
