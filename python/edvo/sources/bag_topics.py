# SPDX-License-Identifier: MIT
"""Which topics of a bag are the colour and the depth of one camera."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

from edvo.errors import Error
from edvo.sources import messages

INFO = "sensor_msgs/msg/CameraInfo"
OTHER_CAMERAS = ("infra", "/ir", "fisheye", "mono", "left", "right")
MOST_NAMED = 6  # topics in a note
First = dict[str, Any]  # the first message of each topic of images


def choose_topics(
    reader: Any, first: First, colour: str | None, depth: str | None, path: Path
) -> tuple[str, str]:
    """Of one camera: the same namespace and frame, with a CameraInfo."""
    colours = candidates(first, "colour", colour, path)
    depths = candidates(first, "depth", depth, path)

    def rank(pair: tuple[str, str]) -> tuple[Any, ...]:
        c, d = pair
        return (
            other_camera(c) + is_grey(first[c]),
            nearest_info(reader, c) is None,
            -shared_parts(c, d),
            *rank_of(c, first[c], ("rgb", "color", "colour")),
            first[c].header.frame_id != first[d].header.frame_id,
            *rank_of(d, first[d], ("aligned", "registered", "depth")),
        )

    return min(product(colours, depths), key=rank)


def left_out(first: First, chosen: tuple[str, str]) -> str:
    """Of several cameras the others, and how to choose them; "" = there are none."""
    # One image is often recorded in several encodings below one name.
    others = [n for n in sorted(first) if n not in chosen and messages.kind_of(first[n])]
    others = [n for n in others if not any(n.startswith(c + "/") for c in (*chosen, *others))]
    if not others:
        return ""
    named = ", ".join(others[:MOST_NAMED]) + (", ..." if len(others) > MOST_NAMED else "")
    return f"left out: {named}; --colour-topic and --depth-topic choose them"


def candidates(first: First, kind: str, wanted: str | None, path: Path) -> list[str]:
    if wanted is not None:
        if wanted not in first:
            raise Error(
                f"--{kind}-topic {wanted}: not in {path}; its images: {', '.join(first)}", code=2
            )
        return [wanted]
    known = sorted(name for name, message in first.items() if messages.kind_of(message) == kind)
    if not known:
        topics = [f"{name} ({messages.encoding_of(m)})" for name, m in first.items()]
        hint = ""
        if kind == "depth" and any(messages.is_picture(m) for m in first.values()):
            hint = "; 8-bit or JPEG depth is a picture of depth: record 16UC1, 32FC1 or 16-bit PNG"
        raise Error(
            f"{path}: no {kind} images; its image topics: {', '.join(topics) or 'none'}{hint}", code=3
        )
    return known


def other_camera(name: str) -> int:
    return sum(word in name.lower() for word in OTHER_CAMERAS)


def is_grey(message: Any) -> int:
    return int(getattr(message, "encoding", "") in ("mono8", "8UC1"))


def rank_of(name: str, message: Any, words: tuple[str, ...]) -> tuple[int, ...]:
    return (
        -sum(word in name.lower() for word in words),
        other_camera(name),
        1 if hasattr(message, "format") else 0,  # raw before compressed
        len(name),
    )


def shared_parts(a: str, b: str) -> int:
    """Of two names from their start: 2 for /camera/color and /camera/depth."""
    shared = 0
    for x, y in zip(a.split("/"), b.split("/")):
        if x != y:
            break
        shared += 1
    return shared


def nearest_info(reader: Any, image_topic: str) -> str | None:
    """The CameraInfo topic that shares most of its name with the images' topic."""
    infos = [n for n, topic in reader.topics.items() if topic.msgtype == INFO and topic.msgcount > 0]
    best = max(infos, key=lambda name: shared_parts(name, image_topic), default=None)
    return best if best is not None and shared_parts(best, image_topic) >= 2 else None
