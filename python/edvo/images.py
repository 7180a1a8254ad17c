# SPDX-License-Identifier: MIT
"""Checks of the arrays that users hand over."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core

Rgb = NDArray[np.uint8]  # H x W x 3
Depth = NDArray[np.float32]  # H x W, [m], NaN = none


def as_array(name: str, image: Any) -> NDArray[Any]:
    if not isinstance(image, np.ndarray):
        raise TypeError(f"{name}: a numpy array is expected, got {type(image).__name__}")
    return image


def unmasked(image: NDArray[Any]) -> NDArray[Any]:
    """Depth of a masked array: 0, which is none, where it is masked."""
    return image.filled(0) if isinstance(image, np.ma.MaskedArray) else image


def check_rgb(rgb: Any, width: int, height: int) -> Rgb:
    """uint8, H x W x 3 or H x W (grey), contiguous; of the camera's size."""
    image = as_array("rgb", rgb)
    if np.ma.is_masked(image):
        raise TypeError(
            "rgb: a masked array; colour has no value for none: mask its depth, or give mask="
        )
    if image.dtype != np.uint8:
        hint = ""
        if image.dtype.kind == "f":
            hint = "; (255 * rgb).round().astype(numpy.uint8) makes it one if it is in [0, 1]"
        raise TypeError(f"rgb: dtype uint8 is expected, got {image.dtype}{hint}")
    if image.ndim == 2:
        image = np.repeat(image[:, :, None], 3, axis=2)
    if image.ndim == 3 and image.shape[2] == 4:
        raise ValueError("rgb: 4 channels; rgb[:, :, :3] leaves the transparency out")
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"rgb: shape (height, width, 3) is expected, got {image.shape}")
    if image.shape[:2] != (height, width):
        raise ValueError(
            f"rgb: {image.shape[1]} x {image.shape[0]} pixels, but the camera has "
            f"{width} x {height}"
        )
    return np.ascontiguousarray(image)


Mask = str | Path | NDArray[np.bool_] | NDArray[np.uint8]


def visible_pixels(mask: Mask, width: int, height: int) -> NDArray[np.uint8]:
    """H x W, 255 = used, 0 = hidden: of an image file (white = used) or an array (not 0 = used)."""
    if isinstance(mask, (str, Path)):
        return np.asarray(_core.read_mask(Path(mask), width, height))
    array = np.asarray(mask)
    if array.dtype not in (np.bool_, np.uint8):
        raise TypeError(f"mask: dtype bool or uint8 is expected, got {array.dtype}")
    if array.shape != (height, width):
        raise ValueError(f"mask: shape ({height}, {width}) is expected, got {array.shape}")
    if not array.any():
        raise ValueError("mask: hides everything; what is to be seen must not be 0")
    return np.ascontiguousarray(np.where(array, 255, 0), np.uint8)


def check_depth(depth: Any, width: int, height: int) -> NDArray[Any]:
    """float32 [m] or uint16 [units], H x W, contiguous; of the camera's size. Masked: 0 = none."""
    image = unmasked(as_array("depth", depth))
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim != 2:
        raise ValueError(f"depth: shape (height, width) is expected, got {image.shape}")
    if image.dtype == np.float64:
        image = image.astype(np.float32)
    if image.dtype not in (np.float32, np.uint16):
        raise TypeError(
            f"depth: dtype float32 (metres) or uint16 (with depth_scale) is expected, got "
            f"{image.dtype}"
        )
    if image.shape != (height, width):
        raise ValueError(
            f"depth: {image.shape[1]} x {image.shape[0]} pixels, but the camera has "
            f"{width} x {height}; edvo.register_depth brings depth of another camera to it"
        )
    return np.ascontiguousarray(image)
