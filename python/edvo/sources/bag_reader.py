# SPDX-License-Identifier: MIT
"""Opens ROS 1 and ROS 2 recordings, also single files of the latter."""

from __future__ import annotations

import json
import shlex
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from edvo.errors import Error, missing_extra
from edvo.sources.untrusted import one_line

MCAP_END = b"\x89MCAP0\r\n"
STORAGES = {".db3": "sqlite3", ".mcap": "mcap"}


def is_bag(path: Path) -> bool:
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix == ".bag" or is_recorded_file(path)


@contextmanager
def open_bag(path: Path) -> Iterator[Any]:
    """An open rosbags.highlevel.AnyReader."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_extra(f"reading {path.name}", "rosbags", "ros") from None
    if not path.exists():
        raise Error(f"{path}: no such file or folder", code=3)
    path = with_metadata(path)
    with tempfile.TemporaryDirectory(prefix="edvo-") as folder:
        place = path
        try:
            if path.suffix in STORAGES and not (path.is_dir()):
                place = Path(folder)
                describe(path, place)
            store = get_typestore(Stores.ROS2_HUMBLE)
            with AnyReader([place], default_typestore=store) as reader:
                name_types(reader)
                yield reader
        except (Error, FileNotFoundError) as error:
            raise error if isinstance(error, Error) else Error(f"{path}: {error}", 3) from None
        except Exception as error:  # noqa: BLE001
            # Types of messages are compiled as the file defines them: any of their fields may be
            # missing or of another type, and the libraries raise exceptions of every kind.
            raise damaged(path, error) from error


MENDERS = {
    ".bag": "rosbag reindex {0}",
    ".mcap": "mcap recover {0} -o mended.mcap",
    ".db3": "sqlite3 {0} .recover | sqlite3 mended.db3",
}


def damaged(path: Path, error: Exception) -> Error:
    """What mends a recording whose recorder was killed, with the file."""
    files = [path]
    if path.is_dir():
        files = [file for file in sorted(path.iterdir()) if file.suffix in STORAGES]
        files = [file for file in files if is_cut_off(file)] or files[:1] or [path]
    file = files[0]
    if file.is_file() and file.stat().st_size == 0:
        return Error(f"{file}: is empty, 0 bytes", code=3)
    mender = MENDERS.get(file.suffix, "").format(shlex.quote(str(file)))
    hint = f"; if it was cut off, `{mender}` mends it" if mender else ""
    return Error(f"{file}: damaged or cut off: {one_line(error)}{hint}", code=3)


def is_cut_off(file: Path) -> bool:
    """An MCAP file without the bytes that end one."""
    if file.suffix != ".mcap":
        return False
    with file.open("rb") as stream:
        stream.seek(-min(len(MCAP_END), file.stat().st_size), 2)
        return stream.read() != MCAP_END


def topics_of_database(file: Path) -> list[tuple[str, str, int]]:
    try:
        address = f"{file.resolve().as_uri()}?mode=ro"
        with closing(sqlite3.connect(address, uri=True)) as database:
            return database.execute(
                "select name, type, (select count(*) from messages where topic_id = topics.id) "
                "from topics"
            ).fetchall()
    except sqlite3.DatabaseError as error:
        raise damaged(file, error) from None


def topics_of_mcap(file: Path) -> list[tuple[str, str, int]]:
    try:
        from mcap.reader import make_reader
    except ImportError:
        raise missing_extra(f"reading {file.name}", "mcap", "ros") from None
    with file.open("rb") as stream:
        try:
            summary = make_reader(stream).get_summary()
        except Exception as error:  # noqa: BLE001: the library raises several kinds
            raise damaged(file, error) from None
    if summary is None:
        raise damaged(file, ValueError("no summary at its end"))
    counts = summary.statistics.channel_message_counts if summary.statistics else {}
    return [
        (channel.topic, summary.schemas[channel.schema_id].name, counts.get(channel.id, 1))
        for channel in summary.channels.values()
        if channel.schema_id in summary.schemas
    ]


def with_metadata(path: Path) -> Path:
    """The folder instead of its only file: its metadata.yaml says how the file is compressed."""
    if path.is_dir() or not is_recorded_file(path):
        return path
    metadata = path.parent / "metadata.yaml"
    files = [f for f in path.parent.iterdir() if is_recorded_file(f)] if metadata.is_file() else []
    if files == [path] and path.name in metadata.read_text(encoding="utf-8", errors="replace"):
        return path.parent
    if path.name.endswith(".zstd"):
        raise Error(
            f"{path}: compressed by ros2 bag; give the folder with its metadata.yaml, or unpack it: "
            f"zstd -d {shlex.quote(path.name)}",
            code=3,
        )
    return path


def is_recorded_file(path: Path) -> bool:
    """Of a ROS 2 recording, as a whole compressed or not."""
    return path.name.removesuffix(".zstd").endswith(tuple(STORAGES))


def full_type(kind: str) -> str:
    """sensor_msgs/Image, as old recorders wrote, is sensor_msgs/msg/Image."""
    package, slash, name = kind.partition("/")
    return f"{package}/msg/{name}" if slash and "/" not in name else kind


def name_types(reader: Any) -> None:
    """Old names made full ones, which are those of the messages' definitions."""
    for storage in (part.storage for part in reader.readers if hasattr(part, "storage")):
        for owner in (reader, storage, *getattr(storage, "storages", ())):
            owner.connections[:] = [
                c._replace(msgtype=full_type(c.msgtype)) if c.msgtype else c for c in owner.connections
            ]


def describe(file: Path, folder: Path) -> None:
    """A folder with the metadata that ros2 bag would have written beside the file."""
    storage = STORAGES[file.suffix]
    topics = topics_of_database(file) if storage == "sqlite3" else topics_of_mcap(file)
    link = folder / f"recording{file.suffix}"  # the library takes ? and # for parts of an address
    link.symlink_to(file.resolve())
    entries = [
        {
            "topic_metadata": {
                "name": str(name),
                "type": full_type(str(kind)),
                "serialization_format": "cdr",
                "offered_qos_profiles": "",
            },
            "message_count": count,
        }
        for name, kind, count in topics
    ]
    information = {
        "version": 5,
        "storage_identifier": storage,
        "duration": {"nanoseconds": 1},
        "starting_time": {"nanoseconds_since_epoch": 0},
        "message_count": sum(count for _, _, count in topics),
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [link.name],
        "topics_with_message_count": entries,
    }
    # JSON is YAML, too, whatever stands in names.
    text = json.dumps({"rosbag2_bagfile_information": information})
    (folder / "metadata.yaml").write_text(text, encoding="utf-8")
