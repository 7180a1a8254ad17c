# SPDX-License-Identifier: MIT
"""Time stamps that are the names of images."""

from __future__ import annotations

import re
from decimal import Decimal
from pathlib import Path

from edvo.errors import Error
from edvo.sources.pairing import Message, Pairing, Topics, pairing_of

UNITS = {"ms": 10**6, "us": 10**3, "ns": 1}  # [ns]
EARLIEST_NS, LATEST_NS = 9 * 10**17, 5 * 10**18  # 1998 to 2128


def unit_of(stems: list[str]) -> str | None:
    """"ms", "us", "ns" or, with a point, "s", if all names are stamps of it since 1970."""
    if stems and all(re.fullmatch(r"\d{9,10}\.\d+", stem) for stem in stems):
        in_time = all(int(Decimal(stem)) * 10**9 <= LATEST_NS for stem in stems)
        return "s" if in_time else None
    if not stems or not all(re.fullmatch(r"\d{12,19}", stem) for stem in stems):
        return None
    for unit, factor in UNITS.items():
        if all(EARLIEST_NS <= int(stem) * factor <= LATEST_NS for stem in stems):
            return unit
    return None


def have_stamps(*folders: list[Path]) -> bool:
    return all(unit_of([file.stem for file in files]) is not None for files in folders)


def stamps_ns(files: list[Path]) -> list[int]:
    stems = [file.stem for file in files]
    unit = unit_of(stems)
    if unit == "s":
        return [int(Decimal(stem) * 10**9) for stem in stems]
    if unit is None:
        raise Error(f"{files[0]}: its name is no time stamp", code=3)
    return [int(stem) * UNITS[unit] for stem in stems]


def written_stamps(file: Path, images: list[Path]) -> list[int] | None:
    """Of images whose names are numbers, as a recorder wrote them, "index seconds" in each line [ns];
    None if one is missing or they do not increase."""
    if not file.is_file():
        return None
    known: dict[int, int] = {}
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        found = re.fullmatch(r"\s*(\d+)[\s,]+(\d+(?:\.\d*)?)\s*", line)
        if found:
            known[int(found[1])] = int(Decimal(found[2]) * 10**9)
    numbers = [re.search(r"(\d+)\D*$", image.stem) for image in images]
    stamps = [known.get(int(number[1])) if number else None for number in numbers]
    whole = [stamp for stamp in stamps if stamp is not None]
    is_whole = len(whole) == len(images) and all(a < b for a, b in zip(whole, whole[1:]))
    return whole if is_whole else None


def pair_by_name(
    colours: list[Path], depths: list[Path]
) -> tuple[list[tuple[int, Path, Path]], Pairing]:
    """Stamp [ns] of colour and both files; raises edvo.Error where there is no pair."""
    messages = [
        Message(is_colour, stamp, file.absolute)
        for is_colour, files in ((True, colours), (False, depths))
        for stamp, file in zip(stamps_ns(files), files)
    ]
    messages.sort(key=lambda message: message.stamp_ns)
    topics = Topics(str(colours[0].parent), str(depths[0].parent))
    pairing = pairing_of(messages, topics, "record both with one clock")
    return [(c.stamp_ns, c.read(), d.read()) for c, d in pairing.pairs], pairing
