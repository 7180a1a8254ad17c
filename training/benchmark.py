# SPDX-License-Identifier: MIT
"""The boundary benchmark's rules: thinning, one-to-one matching within a radius, ODS / OIS / AP.

The standard code finds the assignment of least cost where leaving a pixel alone costs 100 times the
radius, so it first of all matches as many pixels as can be matched. Scores count matches and nothing
else; the size of a maximum matching is therefore the same number.
"""
import ctypes
import hashlib
import os
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

TOLERANCE = 0.0075  # of the diagonal


def triangle(image, radius):
    """Smoothing by a triangle of this radius [pixels], borders mirrored."""
    if radius <= 1:
        weight = np.array([1, 12 / radius / (radius + 2) - 2, 1])
    else:
        rise = np.arange(1, radius + 1)
        weight = np.concatenate([rise, [radius + 1], rise[::-1]])
    weight = weight / weight.sum()
    return cv2.sepFilter2D(image, cv2.CV_32F, weight, weight, borderType=cv2.BORDER_REFLECT)


def suppress(strength):
    """Keeps the crests: pixels not weaker than their two neighbours across the edge."""
    s = triangle(np.asarray(strength, np.float32), 1)
    smooth = triangle(s, 4)
    gy, gx = np.gradient(smooth)
    yy, _ = np.gradient(gy)
    xy, xx = np.gradient(gx)
    angle = np.mod(np.arctan(yy * np.sign(-xy) / (xx + 1e-5)), np.pi)
    rows, columns = np.mgrid[:s.shape[0], :s.shape[1]].astype(np.float32)
    keep = np.ones(s.shape, bool)
    for sign in (-1, 1):
        across = cv2.remap(s, columns + sign * np.cos(angle).astype(np.float32),
                           rows + sign * np.sin(angle).astype(np.float32),
                           cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        keep &= s * 1.01 >= across
    out = np.where(keep, s, 0)
    for i in range(5):  # crests at the border of the image are artefacts: fade them out
        for line in (out[i], out[-1 - i], out[:, i], out[:, -1 - i]):
            line *= i / 5
    return out


@lru_cache(1)
def thinning_tables():
    """For each of the 256 neighbourhoods, whether the first or second pass may delete the pixel."""
    tables = np.zeros((2, 256), np.uint8)
    for code in range(256):
        # Neighbours from the right one on, against the clock: x1 .. x8.
        x = [code >> k & 1 for k in range(8)]
        crossings = sum(not x[k] and (x[k + 1] or x[(k + 2) % 8]) for k in (0, 2, 4, 6))
        first = sum(bool(x[(k - 1) % 8] or x[k]) for k in (0, 2, 4, 6))
        second = sum(bool(x[k] or x[k + 1]) for k in (0, 2, 4, 6))
        if crossings == 1 and 2 <= min(first, second) <= 3:
            tables[0, code] = not ((x[1] or x[2] or not x[7]) and x[0])
            tables[1, code] = not ((x[5] or x[6] or not x[3]) and x[4])
    return tables


NEIGHBOURS = np.zeros((3, 3), np.float32)
for bit, place in enumerate([(1, 2), (0, 2), (0, 1), (0, 0), (1, 0), (2, 0), (2, 1), (2, 2)]):
    NEIGHBOURS[place] = 1 << bit


def thin(mask):
    """Lines of one pixel (Guo and Hall's parallel thinning), connections kept."""
    image = np.asarray(mask).astype(np.uint8)
    while True:
        before = image
        for table in thinning_tables():
            code = cv2.filter2D(image, cv2.CV_32F, NEIGHBOURS, borderType=cv2.BORDER_CONSTANT)
            image = image & ~table[code.astype(np.uint8)] & 1
        if np.array_equal(before, image):
            return image > 0


@lru_cache(1)
def matcher():
    """matching.cpp, compiled once for each state of that file."""
    source = Path(__file__).with_name("matching.cpp")
    digest = hashlib.sha256(source.read_bytes()).hexdigest()[:16]
    library = Path(tempfile.gettempdir()) / f"edvo_matching_{os.getuid()}_{digest}.so"
    if not library.exists():
        part = library.with_suffix(f".{os.getpid()}")
        subprocess.run([os.environ.get("CXX", "c++"), "-O3", "-shared", "-fPIC", "-std=c++17",
                        str(source), "-o", str(part)], check=True)
        part.replace(library)
    function = ctypes.CDLL(str(library)).count_matches
    mask = np.ctypeslib.ndpointer(np.uint8, 2, flags="C_CONTIGUOUS")
    function.argtypes = [mask, mask, ctypes.c_int, ctypes.c_int, ctypes.c_double]
    return function


def count_matches(found, truth, radius):
    """How many pixels of one mask can be paired with one of the other, each used once."""
    if found.shape != truth.shape:
        raise ValueError(f"masks of {found.shape} and {truth.shape}")
    return matcher()(np.ascontiguousarray(found, np.uint8), np.ascontiguousarray(truth, np.uint8),
                     *truth.shape, radius)


def counts_of(masks, truth):
    """For each mask: matched, found, true."""
    radius = TOLERANCE * np.hypot(*truth.shape)
    total = np.count_nonzero(truth)
    return np.array([(count_matches(m, truth, radius), np.count_nonzero(m), total) for m in masks])


def f_measure(counts):
    """counts: ... x (matched, found, true) -> recall, precision, F."""
    matched, found, true = np.moveaxis(np.asarray(counts, float), -1, 0)
    recall = matched / np.maximum(true, 1)
    precision = matched / np.maximum(found, 1)
    return recall, precision, 2 * recall * precision / np.maximum(recall + precision, 1e-12)


def summary(counts, thresholds):
    """counts: images x thresholds x (matched, found, true)."""
    counts = np.asarray(counts)
    recall, precision, f = f_measure(counts.sum(0))
    best = int(np.argmax(f))
    each = f_measure(counts)[2].argmax(1)
    _, _, ois = f_measure(counts[np.arange(len(counts)), each].sum(0))
    order = np.argsort(recall)
    grid = np.linspace(0, 1, 101)
    curve = np.interp(grid, recall[order], precision[order], left=0, right=0)
    curve[grid < recall.min()] = precision[np.argmin(recall)]
    return {"ODS": float(f[best]), "OIS": float(ois), "AP": float(curve.mean()),
            "threshold": float(thresholds[best]), "precision": float(precision[best]),
            "recall": float(recall[best])}
