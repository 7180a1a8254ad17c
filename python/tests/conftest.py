# SPDX-License-Identifier: MIT
"""Rendered sequences that the tests share."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import edvo
from edvo import _core
from edvo.sources import FolderSource

SIZE = (320, 240)


def synth(folder: Path, *flags: str) -> Path:
    status = _core.main(["edvo", "synth", str(folder), "--size", f"{SIZE[0]}x{SIZE[1]}", *flags])
    assert status == 0
    return folder


@pytest.fixture(scope="session")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A TUM folder of 64 frames with ground truth and its camera."""
    return synth(tmp_path_factory.mktemp("synth") / "office", "--frames", "64")


@pytest.fixture(scope="session")
def frames(sequence: Path) -> list[edvo.Frame]:
    return list(FolderSource(sequence))


@pytest.fixture(scope="session")
def camera(sequence: Path) -> edvo.Camera:
    return FolderSource(sequence).camera


class Memory(edvo.Source):
    """Frames from a list."""

    def __init__(self, camera: edvo.Camera, frames: list[edvo.Frame], truth: object = None) -> None:
        super().__init__()
        self.camera = camera
        self.name = self.origin = "memory"
        self.list = frames
        self.frames = len(frames)
        self.ground_truth = truth  # type: ignore[assignment]

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(self.list)


def changed(frames: list[edvo.Frame], **changes: object) -> list[edvo.Frame]:
    """The frames with functions applied to fields: depth=lambda depth: ..."""
    return [
        replace(frame, **{name: change(getattr(frame, name)) for name, change in changes.items()})  # type: ignore[operator]
        for frame in frames
    ]
