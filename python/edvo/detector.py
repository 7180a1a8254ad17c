# SPDX-License-Identifier: MIT
"""Edge detectors of one's own."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray


class EdgeDetector(ABC):
    """Finds the edges of keyframes: subclass it and write ``strength``.

    What it gives is used as a network's edge strength is: edges are where gradient times
    strength ** ``network.edge_exponent`` has its ridges (docs/adr/0007). Called by the thread that
    tracks, while it holds the GIL, once for each image that may become a keyframe; it must give the
    same for the same image. What it raises ends ``process`` in an ``edvo.Error`` with it as cause;
    call ``reset`` before the next image then.
    """

    _failure: BaseException | None = None

    @abstractmethod
    def strength(self, rgb: NDArray[np.uint8]) -> NDArray[np.floating]:
        """H x W x 3, uint8, RGB, undistorted, to H x W floats in [0, 1]."""

    def _strength(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Checked, for C++."""
        self._failure = None
        try:
            return check_strength(self.strength(rgb), rgb.shape[:2])
        except BaseException as error:
            self._failure = error
            raise

    def _take_failure(self) -> BaseException | None:
        failure, self._failure = self._failure, None
        return failure


def require_detector(detector: object) -> None:
    """None, or an instance of ``EdgeDetector``."""
    if detector is None or isinstance(detector, EdgeDetector):
        return
    given = f"the class {detector.__name__}" if isinstance(detector, type) else type(detector).__name__
    raise TypeError(
        f"detector: an instance of a subclass of edvo.EdgeDetector is expected, got {given}"
    )


def check_strength(strength: object, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """float, of the image's height and width, finite, in [0, 1]."""
    if not isinstance(strength, np.ndarray):
        raise TypeError(f"edge strength: a numpy array is expected, got {type(strength).__name__}")
    if strength.dtype.kind != "f":
        raise TypeError(f"edge strength: floats in [0, 1] are expected, got {strength.dtype}")
    if strength.shape != shape:
        raise ValueError(f"edge strength: shape {shape} is expected, got {strength.shape}")
    if not (np.min(strength) >= 0 and np.max(strength) <= 1):
        raise ValueError("edge strength: not all values are in [0, 1]")
    return np.ascontiguousarray(strength, np.float32)
