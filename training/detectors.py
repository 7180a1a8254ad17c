# SPDX-License-Identifier: MIT
"""Edge detectors behind one call: image -> strength. Networks by their description, and Canny."""
from pathlib import Path

import cv2
import numpy as np


def read_description(path):
    """The keys that edvo reads (docs/models.md), from TOML as plain as export.py writes it."""
    try:
        import tomllib
        return tomllib.loads(Path(path).read_text())
    except ImportError:
        import toml
        return toml.loads(Path(path).read_text())


class Network:
    """What edvo's own detector does, through the same OpenCV."""

    def __init__(self, description):
        keys = read_description(description)
        self.net = cv2.dnn.readNetFromONNX(str(Path(description).parent / keys["file"]))
        rule = keys.get("input", {})
        self.mean = rule.get("mean", [0, 0, 0])
        self.scale = rule.get("scale", 1.0)
        self.stride = rule.get("multiple_of", 1)
        self.swap = rule.get("channels", "bgr") == "rgb"
        self.sigmoid = keys.get("output", {}).get("activation", "none") == "sigmoid"

    def __call__(self, bgr):
        height, width = bgr.shape[:2]
        padded = cv2.copyMakeBorder(bgr, 0, -height % self.stride, 0, -width % self.stride,
                                    cv2.BORDER_REFLECT_101)
        self.net.setInput(cv2.dnn.blobFromImage(padded, self.scale, mean=self.mean,
                                                swapRB=self.swap))
        answer = self.net.forward()[0, 0, :height, :width]
        return 1 / (1 + np.exp(-answer)) if self.sigmoid else np.clip(answer, 0, 1)


class Plain:
    """An ONNX file of 0..255 BGR -> probabilities, stride 8: a teacher."""

    def __init__(self, path):
        self.net = cv2.dnn.readNetFromONNX(str(path))

    def __call__(self, bgr):
        height, width = bgr.shape[:2]
        padded = cv2.copyMakeBorder(bgr, 0, -height % 8, 0, -width % 8, cv2.BORDER_REFLECT_101)
        self.net.setInput(np.ascontiguousarray(padded.transpose(2, 0, 1)[None], np.float32))
        return self.net.forward()[0, 0, :height, :width].copy()


class Canny:
    """Gaussian blur, then Canny; `levels` asks for the highest threshold at which a pixel is one."""

    def __init__(self, sigma=1.0, low_ratio=0.4, highest=800):
        self.sigma, self.low_ratio, self.highest = sigma, low_ratio, highest

    def at(self, bgr, threshold):
        """Edges at a threshold of 0..1."""
        gray = cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY)
        if self.sigma > 0:
            gray = cv2.GaussianBlur(gray, (0, 0), self.sigma)
        high = threshold * self.highest
        return cv2.Canny(gray, self.low_ratio * high, high) > 0


class Enlarged:
    """A detector that is shown the image enlarged; its strength comes back at the image's size."""

    def __init__(self, detector, zoom):
        self.detector, self.zoom = detector, zoom

    def __call__(self, bgr):
        seen = cv2.resize(bgr, None, fx=self.zoom, fy=self.zoom, interpolation=cv2.INTER_CUBIC)
        return cv2.resize(self.detector(seen), bgr.shape[1::-1], interpolation=cv2.INTER_AREA)


class Together:
    """The mean of several detectors' logits, as a probability."""

    LEAST = 1e-4  # a probability of 0 has no logit

    def __init__(self, names):
        self.parts = [make(name) for name in names]

    def __call__(self, bgr):
        said = np.clip([part(bgr) for part in self.parts], self.LEAST, 1 - self.LEAST)
        return 1 / (1 + np.exp(-np.log(said / (1 - said)).mean(0)))


def make(name):
    """canny | FILE.toml | FILE.onnx, with @ZOOM behind it to be shown the image enlarged"""
    name, _, zoom = str(name).partition("@")
    if zoom:
        return Enlarged(make(name), float(zoom))
    if name == "canny":
        return Canny()
    return Network(name) if name.endswith(".toml") else Plain(name)
