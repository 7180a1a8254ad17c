# SPDX-License-Identifier: MIT
"""RVL, the lossless compression of depth of A. D. Wilson, Fast Lossless Depth Image Compression,
ISS 2017: runs of zeros and of others in turn, differences as numbers of 3 bits a nibble."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from edvo.errors import Error

MOST_NIBBLES = 11  # of 3 bits, of a number of 32


def numbers_of(data: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Nibbles of words of 32 bits, the highest first; bit 8 of a nibble: the number goes on."""
    words = np.frombuffer(data[: len(data) // 4 * 4].tobytes(), "<u4")
    shifts = np.arange(28, -4, -4, dtype=np.uint32)
    nibbles = ((words[:, None] >> shifts) & 15).reshape(-1).astype(np.int64)
    ends = np.flatnonzero(nibbles < 8)
    if len(ends) == 0:
        return np.zeros(0, np.int64)
    begins = np.concatenate([[0], ends[:-1] + 1])
    place = np.arange(ends[-1] + 1) - np.repeat(begins, ends - begins + 1)
    if int(place.max()) >= MOST_NIBBLES:
        raise Error("depth compressed as RVL: damaged", code=3)
    return np.asarray(np.add.reduceat((nibbles[: ends[-1] + 1] & 7) << (3 * place), begins))


def decode_rvl(data: NDArray[np.uint8], height: int, width: int) -> NDArray[np.uint16]:
    """H x W, in units; 0 = none. Raises ``edvo.Error`` where the data end too early or do not fit."""
    numbers = numbers_of(data)
    pixels = height * width
    depth = np.zeros(pixels, np.uint16)
    at, done, last = 0, 0, 0
    while done < pixels:
        if at + 2 > len(numbers):
            raise Error("depth compressed as RVL: its data end too early", code=3)
        zeros, others = int(numbers[at]), int(numbers[at + 1])
        at, done = at + 2, done + zeros
        if done + others > pixels or at + others > len(numbers) or zeros + others == 0:
            raise Error("depth compressed as RVL: damaged", code=3)
        zigzag = numbers[at : at + others]
        values = last + np.cumsum((zigzag >> 1) ^ -(zigzag & 1))
        depth[done : done + others] = values & 0xFFFF
        last = int(values[-1]) if others else last
        at, done = at + others, done + others
    return depth.reshape(height, width)
