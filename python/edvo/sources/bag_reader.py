# SPDX-License-Identifier: MIT
"""Opens ROS 1 and ROS 2 recordings, also single files of the latter."""

from __future__ import annotations

import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from edvo.errors import Error, missing_extra

STORAGES = {".db3": "sqlite3", ".mcap": "mcap"}


def is_bag(path: Path) -> bool:
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    return path.suffix in (".bag", *STORAGES)


@contextmanager
def open_bag(path: Path) -> Iterator[Any]:
    """An open rosbags.highlevel.AnyReader."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise missing_extra(f"reading {path.name}", "rosbags", "ros") from None
    if not path.exists():
        raise Error(f"{path}: no such file or folder", code=3)
    with tempfile.TemporaryDirectory(prefix="edvo-") as folder:
        place = path
        if path.suffix in STORAGES and not (path.is_dir()):
            place = Path(folder)
            describe(path, place)
        try:
            store = get_typestore(Stores.ROS2_HUMBLE)
            with AnyReader([place], default_typestore=store) as reader:
                yield reader
        except (AnyReaderError, FileNotFoundError) as error:
            raise Error(f"{path}: {error}", code=3) from None


def topics_of_database(file: Path) -> list[tuple[str, str, int]]:
    try:
        with sqlite3.connect(f"file:{file}?mode=ro", uri=True) as database:
            return database.execute(
                "select name, type, (select count(*) from messages where topic_id = topics.id) "
                "from topics"
            ).fetchall()
    except sqlite3.DatabaseError as error:
        raise Error(f"{file}: no ROS 2 recording: {error}", code=3) from None


def topics_of_mcap(file: Path) -> list[tuple[str, str, int]]:
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
    except ImportError:
        raise missing_extra(f"reading {file.name}", "mcap", "ros") from None
    with file.open("rb") as stream:
        try:
            summary = make_reader(stream).get_summary()
        except McapError as error:
            raise Error(f"{file}: no MCAP file: {error!r}", code=3) from None
    if summary is None:
        raise Error(f"{file}: has no summary (cut off?); `mcap recover` mends it", code=3)
    counts = summary.statistics.channel_message_counts if summary.statistics else {}
    return [
        (channel.topic, summary.schemas[channel.schema_id].name, counts.get(channel.id, 1))
        for channel in summary.channels.values()
        if channel.schema_id in summary.schemas
    ]


def describe(file: Path, folder: Path) -> None:
    """A folder with the metadata that ros2 bag would have written beside the file."""
    storage = STORAGES[file.suffix]
    topics = topics_of_database(file) if storage == "sqlite3" else topics_of_mcap(file)
    (folder / file.name).symlink_to(file.resolve())
    lines = [
        "rosbag2_bagfile_information:",
        "  version: 5",
        f"  storage_identifier: {storage}",
        "  duration: {nanoseconds: 1}",
        "  starting_time: {nanoseconds_since_epoch: 0}",
        f"  message_count: {sum(count for _, _, count in topics)}",
        "  compression_format: ''",
        "  compression_mode: ''",
        f"  relative_file_paths: ['{file.name}']",
        "  topics_with_message_count:",
    ]
    for name, kind, count in topics:
        meta = f"{{name: {name}, type: {kind}, serialization_format: cdr, offered_qos_profiles: ''}}"
        lines.append(f"    - {{topic_metadata: {meta}, message_count: {count}}}")
    (folder / "metadata.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
