# SPDX-License-Identifier: MIT
"""Colour and depth messages of a bag, paired by time."""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo.errors import Error
from edvo.sources.untrusted import one_line

LARGEST_GAP_NS = 20_000_000  # between a colour image and its depth
MOST_WAITING = 60  # depth images that wait for their colour


@dataclass(frozen=True)
class Message:
    """An image that is deserialized where it is needed: a damaged one costs its own frame only."""

    is_colour: bool
    stamp_ns: int  # of its header, or of its arrival where headers have no time
    read: Callable[[], Any]  # raises edvo.Error if it is damaged


@dataclass(frozen=True)
class Topics:
    colour: str
    depth: str
    by_arrival: bool = False  # the headers have no time


def header_stamp_ns(raw: bytes, is_ros2: bool) -> int:
    """Of a message that begins with a std_msgs/Header, without reading the rest."""
    order = ">" if is_ros2 and raw[1:2] == b"\0" else "<"
    seconds, nanoseconds = struct.unpack_from(order + "II", raw, 4)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


def reads(reader: Any, topic: str, raw: bytes, kind: str) -> Callable[[], Any]:
    """Deserializes; also when the bag is closed already."""
    store = reader.typestore
    deserialize = store.deserialize_cdr if reader.is2 else store.deserialize_ros1

    def read() -> Any:
        try:
            return deserialize(raw, kind)
        except Exception as error:  # noqa: BLE001: the library raises several kinds
            raise Error(f"{topic}: damaged message of {len(raw)} bytes: {one_line(error)}", code=3) from None

    return read


def messages_of(reader: Any, topics: Topics) -> Iterator[Message]:
    connections = [c for c in reader.connections if c.topic in (topics.colour, topics.depth)]
    for connection, arrival, raw in reader.messages(connections=connections):
        has_stamp = len(raw) >= 12 and not topics.by_arrival
        stamp = header_stamp_ns(raw, reader.is2) if has_stamp else arrival
        read = reads(reader, connection.topic, raw, connection.msgtype)
        yield Message(connection.topic == topics.colour, stamp, read)


def pair(messages: Iterable[Message]) -> Iterator[tuple[Message, Message]]:
    """Each colour image with the depth nearest in time, each depth once."""
    colours: deque[Message] = deque()
    depths: deque[Message] = deque()
    for message in messages:
        (colours if message.is_colour else depths).append(message)
        while colours and depths:
            if depths[-1].stamp_ns < colours[0].stamp_ns and len(depths) < MOST_WAITING:
                break
            yield from match(colours, depths)
    while colours and depths:
        yield from match(colours, depths)


def match(colours: deque[Message], depths: deque[Message]) -> Iterator[tuple[Message, Message]]:
    """The pair of the first colour image, if it has depth."""
    colour = colours.popleft()
    gaps = [abs(depth.stamp_ns - colour.stamp_ns) for depth in depths]
    nearest = int(np.argmin(gaps))
    if gaps[nearest] > LARGEST_GAP_NS:
        while len(depths) > 1 and depths[0].stamp_ns < colour.stamp_ns - LARGEST_GAP_NS:
            depths.popleft()
        return
    for _ in range(nearest):
        depths.popleft()
    yield colour, depths.popleft()


@dataclass(frozen=True)
class Pairing:
    topics: Topics
    pairs: list[tuple[Message, Message]]

    @property
    def stamps_ns(self) -> NDArray[np.int64]:
        """Of the colour images that have depth."""
        return np.array([colour.stamp_ns for colour, _ in self.pairs], np.int64)

    @property
    def depth_delay_ns(self) -> int:
        """Median of depth's stamps less colour's."""
        return int(np.median([depth.stamp_ns - colour.stamp_ns for colour, depth in self.pairs]))

    def note(self, colours: int, depths: int) -> str:
        text = (
            f"{len(self.pairs)} pairs of {colours} colour and {depths} depth images, "
            f"depth {1e-6 * self.depth_delay_ns:+.0f} ms from colour (median)"
        )
        if self.topics.by_arrival:
            text += "; the headers have no time, so it is that at which messages were recorded"
        return text


def pairing_of(messages: list[Message], topics: Topics, mend: str) -> Pairing:
    """Raises edvo.Error where there is no pair; ``mend`` says what helps."""
    pairs = list(pair(messages))
    if not pairs:
        raise Error(f"{say_no_pair(topics, messages)}; {mend}", code=3)
    return Pairing(topics, pairs)


def pair_bag(reader: Any, topics: Topics, path: Path) -> tuple[Pairing, str]:
    """From the stamps of all images, with a note."""
    stamped = stamps_of(reader, topics)
    if any(not any(m.stamp_ns for m in stamped if m.is_colour == kind) for kind in (True, False)):
        topics = Topics(topics.colour, topics.depth, by_arrival=True)
        stamped = stamps_of(reader, topics)
    mend = "record both with one clock, or choose others with --colour-topic and --depth-topic"
    try:
        pairing = pairing_of(stamped, topics, mend)
    except Error as error:
        raise Error(f"{path}: {error}", error.code) from None
    colours = sum(message.is_colour for message in stamped)
    return pairing, pairing.note(colours, len(stamped) - colours)


def stamps_of(reader: Any, topics: Topics) -> list[Message]:
    """Without the images themselves."""
    return [Message(m.is_colour, m.stamp_ns, lambda: None) for m in messages_of(reader, topics)]


def say_no_pair(topics: Topics, messages: list[Message]) -> str:
    colours = [m.stamp_ns for m in messages if m.is_colour]
    depths = [m.stamp_ns for m in messages if not m.is_colour]
    if not colours or not depths:
        return f"no image of {topics.depth if colours else topics.colour}"

    def span(topic: str, stamps: list[int]) -> str:
        return f"{topic} has {len(stamps)} from {1e-9 * min(stamps):.3f} to {1e-9 * max(stamps):.3f} s"

    return (
        f"no colour image has depth within {1e-6 * LARGEST_GAP_NS:.0f} ms: "
        f"{span(topics.colour, colours)}, {span(topics.depth, depths)}, "
        f"{1e-9 * (min(depths) - min(colours)):+.3f} s from colour"
    )
