# SPDX-License-Identifier: MIT
"""Frames of which each is two files, read and decoded when their turn comes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from edvo.registration import DepthRegistration
from edvo.sources.base import Arrays, Frame, Source, require_size
from edvo.sources.untrusted import reading


@dataclass(frozen=True)
class Entry:
    stamp_ns: int
    colour: Callable[[], NDArray[np.uint8]]  # H x W x 3, RGB
    depth: Callable[[], NDArray[np.float32]]  # [m]


class ListedSource(Source):
    """``registration``, if there is one, brings each depth image to the colour camera."""

    def __init__(
        self, entries: list[Entry], registration: DepthRegistration | None = None
    ) -> None:
        super().__init__()
        self.entries = entries
        self.registration = registration
        self.frames = len(entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __getitem__(self, index: int) -> Frame:
        entry = self.entries[index]
        what = f"{self.origin}: frame {index}"
        rgb, depth = entry.colour(), entry.depth()
        if self.registration is not None:
            with reading(what):  # of another size than the first one
                depth = self.registration(depth)
        return require_size(Frame(entry.stamp_ns, rgb, depth), self.camera, what)

    def __iter__(self) -> Iterator[Frame]:
        for index in range(len(self.entries)):
            yield self[index]

    def _pending(self) -> Iterator[tuple[int, int, Callable[[], Arrays]]]:
        # Read where it is needed: a damaged image costs its own frame only.
        for index, entry in enumerate(self.entries):
            yield entry.stamp_ns, 9, self._loader(lambda index=index: self[index])  # type: ignore[misc]


def shrunk(rgb: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """The mean of factor x factor pixels; what does not fill a block is cut off."""
    if factor == 1:
        return rgb
    height, width = rgb.shape[0] // factor, rgb.shape[1] // factor
    count = factor * factor
    total = np.full((height, width, 3), count // 2, np.uint16 if factor < 16 else np.uint32)
    for y in range(factor):
        for x in range(factor):
            total += rgb[y : height * factor : factor, x : width * factor : factor]
    return (total // count).astype(np.uint8)
