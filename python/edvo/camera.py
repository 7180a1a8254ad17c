# SPDX-License-Identifier: MIT
"""Cameras."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.errors import Error

MOST_SIDE = 1e6  # [px], as in the C++ library's files
CameraTuple = tuple[float, float, float, float, int, int, tuple[float, ...], bool]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with lens distortion.

    Focal lengths and principal point in pixels; pixel centres are integers. ``fy`` may be negative
    (ICL-NUIM's y axis points up). ``distortion`` is k1 k2 p1 p2 k3 k4 k5 k6 in OpenCV's order and
    model, padded with zeros, or k1 k2 k3 k4 of OpenCV's fisheye model if ``equidistant``. Raises
    TypeError for what is no number, ``edvo.Error`` (code 5) for values that no camera has, which the
    program refuses in files, too.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int
    distortion: tuple[float, ...] = (0.0,) * 8
    equidistant: bool = False

    def __post_init__(self) -> None:
        for name in ("fx", "fy", "cx", "cy"):
            object.__setattr__(self, name, as_number(name, getattr(self, name)))
        for name in ("width", "height"):
            side = as_number(name, getattr(self, name))
            if not side.is_integer():
                raise ValueError(f"Camera: {name} {side}: a whole number of pixels is expected")
            if abs(side) > MOST_SIDE:
                raise Error(f"Camera: {name} {side:g}: more pixels than an image has", 5)
            object.__setattr__(self, name, int(side))
        most = 4 if self.equidistant else 8
        if any(self.distortion[most:]):
            raise ValueError(
                f"distortion has {len(self.distortion)} coefficients, at most "
                + ("k1 k2 k3 k4" if self.equidistant else "k1 k2 p1 p2 k3 k4 k5 k6")
            )
        padded = ([float(value) for value in self.distortion] + [0.0] * 8)[:8]
        object.__setattr__(self, "distortion", tuple(padded))
        _core.require_possible_camera(as_tuple(self))

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The 3 x 3 matrix K."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], float)

    def scaled_to(self, width: int, height: int) -> Camera:
        """The same camera for images resized to width x height.

        Resizing keeps the borders of the image, half a pixel outside the outermost centres.
        """
        sx, sy = width / self.width, height / self.height
        return Camera(
            self.fx * sx,
            self.fy * sy,
            (self.cx + 0.5) * sx - 0.5,
            (self.cy + 0.5) * sy - 0.5,
            width,
            height,
            self.distortion,
            self.equidistant,
        )

    @staticmethod
    def read(file: str | Path, width: int = 0, height: int = 0) -> Camera:
        """Reads edvo's TOML, OpenCV's or ROS's YAML, a Kalibr camchain or plain numbers.

        The size is needed where the file does not say it.
        """
        return from_tuple(_core.read_camera(Path(file), width, height))

    def to_toml(self) -> str:
        """The camera as ``edvo run --camera`` reads it, to the last bit."""
        return str(_core.camera_to_toml(as_tuple(self)))


def as_number(name: str, value: object) -> float:
    try:
        if not isinstance(value, (str, bytes)):
            return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        pass
    raise TypeError(f"Camera: {name} {value!r}: a number is expected")


def read_scaled(
    camera: Camera | str | Path, calibrated: tuple[int, int], images: tuple[int, int]
) -> Camera:
    """A camera for images of a size, calibrated with those of another; (0, 0) = of the same."""
    size = calibrated if calibrated != (0, 0) else images
    read = camera if isinstance(camera, Camera) else Camera.read(camera, *size)
    return read.scaled_to(*images) if calibrated != (0, 0) else read


def as_tuple(camera: Camera) -> CameraTuple:
    return (
        float(camera.fx),
        float(camera.fy),
        float(camera.cx),
        float(camera.cy),
        int(camera.width),
        int(camera.height),
        camera.distortion,
        camera.equidistant,
    )


def from_tuple(
    values: tuple[float, float, float, float, int, int, Iterable[float], bool],
) -> Camera:
    fx, fy, cx, cy, width, height, distortion, equidistant = values
    return Camera(fx, fy, cx, cy, width, height, tuple(distortion), equidistant)
