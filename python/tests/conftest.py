# SPDX-License-Identifier: MIT
"""Rendered sequences that the tests share."""

from __future__ import annotations

from pathlib import Path

import pytest

import edvo
from edvo import _core
from edvo.sources import FolderSource
from planted import Memory, changed  # noqa: F401: for the tests

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
