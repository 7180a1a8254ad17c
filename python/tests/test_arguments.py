# SPDX-License-Identifier: MIT
"""What is handed over and cannot be used is refused, by what, where and how to mend it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Memory

import edvo

Frames = list[edvo.Frame]


class Watcher(edvo.Observer):
    pass


class Half(edvo.Source):
    def __init__(self, camera: object) -> None:  # forgets its base
        self.camera = camera  # type: ignore[assignment]

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(())


class NoCamera(Half):
    def __init__(self) -> None:
        edvo.Source.__init__(self)
        self.camera = None  # type: ignore[assignment]


def test_run_takes_the_keywords_of_its_source(sequence: Path) -> None:
    run = edvo.run(sequence, max_frames=3, depth_scale=2500, doctor=False)
    same = edvo.run(sequence, max_frames=3, source_options={"depth_scale": 2500}, doctor=False)
    other = edvo.run(sequence, max_frames=3, doctor=False)
    assert np.array_equal(run.trajectory.values, same.trajectory.values)
    assert not np.array_equal(run.trajectory.values, other.trajectory.values)
    with pytest.raises(TypeError, match="depth_scale: given as a keyword and in source_options"):
        edvo.run(sequence, depth_scale=1, source_options={"depth_scale": 1})


@pytest.mark.parametrize(
    ("keywords", "error", "words"),
    [
        ({"maxframes": 3}, TypeError, "unknown keyword 'maxframes'.*camera.*group.field"),
        ({"keyframes.perod": 3}, edvo.Error, "keyframes.period"),
        ({"detector": lambda rgb: rgb}, TypeError, "edvo.EdgeDetector is expected, got function"),
        ({"detector": edvo.EdgeDetector}, TypeError, "got the class EdgeDetector"),
        ({"observers": [Watcher]}, TypeError, r"Watcher is a class; .*Watcher\(\)"),
        ({"observers": [print]}, TypeError, "edvo.Observer are expected, got builtin"),
        ({"observers": Watcher()}, TypeError, "a list is expected, got Watcher"),
    ],
)
def test_run_checks_its_keywords_before_it_opens_anything(
    keywords: dict[str, Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        edvo.run("/nowhere", **keywords)


def test_run_checks_the_source(camera: edvo.Camera, frames: Frames) -> None:
    with pytest.raises(TypeError, match="Half: its __init__ must call super"):
        edvo.run(Half(camera))
    with pytest.raises(TypeError, match="NoCamera: its camera must be an edvo.Camera, not NoneType"):
        edvo.run(NoCamera())
    with pytest.raises(TypeError, match="an edvo.Source is expected, got NoCamera"):
        edvo.run(NoCamera)  # type: ignore[arg-type]
    for keywords in ({"source_options": {"depth_scale": 5000}}, {"camera": camera}):
        with pytest.raises(TypeError, match="for open_source, which opens paths; Memory is open"):
            edvo.run(Memory(camera, frames[:2]), **keywords)  # type: ignore[arg-type]


def test_a_run_that_tracks_nothing_is_an_error(camera: edvo.Camera, frames: Frames) -> None:
    blind = [edvo.Frame(f.stamp_ns, f.rgb, np.full_like(f.depth, np.nan)) for f in frames[:3]]
    for given, words in (([], "none of 0 frames"), (blind, "none of 3 frames")):
        with pytest.raises(edvo.Error, match=words) as caught:
            edvo.run(Memory(camera, given))
        assert caught.value.code == 9
        assert caught.value.run is not None and len(caught.value.run.frames) == len(given)


def test_a_run_and_a_trajectory_are_short_to_print(sequence: Path) -> None:
    run = edvo.run(sequence, max_frames=5, doctor=False)
    assert repr(run) == "Run('office': 5 tracked)"
    assert re.fullmatch(r"Trajectory\(5 poses, .* s to .* s\)", repr(run.trajectory))
    assert repr(edvo.Trajectory(np.zeros(0), np.zeros((0, 7)))) == "Trajectory(no poses)"
