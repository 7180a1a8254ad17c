# SPDX-License-Identifier: MIT
"""A whole sequence through the odometry."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from edvo import _core
from edvo.camera import Camera
from edvo.detector import EdgeDetector, require_detector
from edvo.doctor import Finding, gravest
from edvo.errors import Error, in_python
from edvo.evaluation import Evaluation, evaluate
from edvo.images import Mask, visible_pixels
from edvo.observer import Observer, SourceInfo, require_observers, source_info
from edvo.odometry import FrameResult, Link, Options, Value, raise_cause, result_from
from edvo.sources import Source, open_source
from edvo.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Run:
    """What a run leaves."""

    source: SourceInfo
    trajectory: Trajectory  # as known at the end; lost frames left out
    online: Trajectory  # each pose as known when its frame was processed
    keyframes: Trajectory  # as known at the end
    frames: list[FrameResult]  # as known at the time
    skipped: list[str]  # why, one for each frame that could not be read or used
    counts: dict[str, int]  # tracked, lost, restarted, relocalized, skipped, dropped, segments
    wall_seconds: float  # from the first frame asked for to the last pose
    finish_seconds: float  # of the last pass over the whole recording, after that
    interrupted: bool = False  # by ctrl-C
    error: Error | None = None  # what ended it before the last frame, or why it is of no use
    links: list[Link] = field(default_factory=list)  # what became of places seen again
    findings: tuple[Finding, ...] = ()  # the doctor's gravest, if it was asked
    map_segments: tuple[int, ...] | None = None  # found in the earlier map; None = there is none

    def __repr__(self) -> str:
        rare = {name: count for name, count in self.counts.items() if name != "tracked" and count}
        if rare.get("segments") == 1:
            del rare["segments"]
        others = "".join(f", {count} {name}" for name, count in rare.items())
        return f"Run({self.source.name!r}: {self.tracked} tracked{others})"

    @property
    def tracked(self) -> int:
        return self.counts["tracked"]

    @property
    def lost(self) -> int:
        return self.counts["lost"]

    @cached_property
    def evaluation(self) -> Evaluation | None:
        """Against the source's ground truth, by the TUM protocol; None without one, or where the
        two cannot be compared (``edvo.evaluate`` says why)."""
        truth = self.source.ground_truth
        if truth is None or len(self.trajectory) == 0:
            return None
        try:
            due = len(self.frames) + len(self.skipped)
            return evaluate(truth, self.trajectory, frames=due)
        except Error:
            return None

    def write(self, folder: str | Path) -> None:
        """trajectory.tum, trajectory_online.tum and keyframes.tum into a folder; ``output`` of
        ``edvo.run`` writes all that the program does."""
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        self.trajectory.write(place / "trajectory.tum")
        self.online.write(place / "trajectory_online.tum")
        self.keyframes.write(place / "keyframes.tum")


TRACKED_NOTHING = 9  # code of an error


def error_from(fields: dict[str, Any]) -> Error | None:
    """Of a run; if every frame was unusable, with the reason of the first."""
    if fields["error"] is None:
        return None
    message, code = fields["error"]
    if code == TRACKED_NOTHING and fields["skipped"]:
        message += f"; {fields['skipped'][0]}"
    return Error(message, code)


def run_from(fields: dict[str, Any], findings: tuple[Finding, ...] = ()) -> Run:
    segments = fields.get("map_segments")  # not known to observers
    return Run(
        source=source_info(fields["source"]),
        trajectory=Trajectory._from_arrays(fields["trajectory"]),
        online=Trajectory._from_arrays(fields["online"]),
        keyframes=Trajectory._from_arrays(fields["keyframes"]),
        frames=[result_from(result) for result in fields["frames"]],
        skipped=fields["skipped"],
        counts=fields["counts"],
        wall_seconds=fields["wall_seconds"],
        finish_seconds=fields["finish_seconds"],
        interrupted=fields["interrupted"],
        error=error_from(fields),
        links=[Link(**link) for link in fields["links"]],
        findings=findings,
        map_segments=None if segments is None else tuple(segments),
    )


SOURCE_KEYWORDS = tuple(inspect.signature(open_source).parameters)[1:]  # all but the path


def split_keywords(given: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Value]]:
    """Those of ``open_source``, and the options, whose names have a point."""
    unknown = [name for name in given if "." not in name and name not in SOURCE_KEYWORDS]
    if unknown:
        raise TypeError(
            f"run: unknown keyword {unknown[0]!r}; besides its own it takes those of open_source "
            f"({', '.join(SOURCE_KEYWORDS)}) and options as **{{'group.field': value}}"
        )
    of_source = {name: value for name, value in given.items() if name in SOURCE_KEYWORDS}
    return of_source, {name: value for name, value in given.items() if "." in name}


def opened_source(source: Source | str | Path, keywords: dict[str, Any]) -> Source:
    """A path opened with these; a ``Source``, which takes none, if it can be run."""
    if isinstance(source, (str, Path)):
        return open_source(source, **keywords)
    if isinstance(source, type) or not isinstance(source, Source):
        name = source.__name__ if isinstance(source, type) else type(source).__name__
        raise TypeError(f"source: a path or an edvo.Source is expected, got {name}")
    kind = type(source).__name__
    if keywords:
        raise TypeError(
            f"run: {', '.join(keywords)}: for open_source, which opens paths; {kind} is open"
        )
    if not hasattr(source, "notes"):
        raise TypeError(f"{kind}: its __init__ must call super().__init__() first")
    if not isinstance(getattr(source, "camera", None), Camera):
        given = type(getattr(source, "camera", None)).__name__
        raise TypeError(f"{kind}: its camera must be an edvo.Camera, not {given}")
    return source


def run(
    source: Source | str | Path,
    *,
    options: Options | None = None,
    method: str = _core.default_method,
    observers: Iterable[Observer] = (),
    max_frames: int | None = None,
    threads: int = 2,
    output: str | Path | None = None,
    force: bool = False,
    source_options: dict[str, Any] | None = None,
    doctor: bool = True,
    detector: EdgeDetector | None = None,
    loops: bool = True,
    final_pass: bool = True,
    map: str | Path | None = None,
    save_map: str | Path | None = None,
    update_map: bool = False,
    mask: Mask | None = None,
    **keywords: Any,
) -> Run:
    """Tracks every frame of a recording, as ``edvo run`` does, to the same bits.

    ``source``: a ``Source``, or a path for ``open_source``, whose keywords are taken here too
    (``camera=``, ``depth_scale=``, ...; or as a dictionary, ``source_options``). ``options``, or
    ``method`` and keywords "group.field", and ``detector``, as for ``Odometry``. ``threads``: one of them tracks, the
    others read ahead. ``output``: a folder for all that the program writes (docs/runs.md), whose
    earlier run is replaced with ``force``. ``doctor``: of a path, look for grave faults first (``Run.findings``; they are in
    the report, too). ``loops``, ``final_pass``: what ``--no-loops`` and ``--no-final-pass`` leave out.
    ``map``: a saved map in whose frame the poses are where the run is found in it (``Run.map_segments``;
    if it is not, ``edvo.Error``), ``update_map`` extends it; ``save_map``: a file for this run's own
    (docs/maps.md), which replaces an earlier map only with ``force``. ``mask``: an image file or H x W array, black or 0 where colour images show what
    moves with the camera, as a robot's arm: not used. Frames that cannot be read or used are skipped and counted; ctrl-C ends the run,
    whose results so far are its results. Raises ``edvo.Error`` whose ``run`` has what was done: if the
    source or an observer fails on the way (what it raised is the ``__cause__``), and with code 9 if no frame could
    be tracked, as the program exits.
    """
    of_source, changes = split_keywords(keywords)
    twice = sorted(of_source.keys() & (source_options or {}).keys())
    if twice:
        raise TypeError(f"run: {', '.join(twice)}: given as a keyword and in source_options")
    of_source |= source_options or {}
    if options is not None and (changes or method != _core.default_method):
        raise ValueError("give options, or a method and keywords, not both")
    if max_frames is not None and max_frames < 1:
        raise ValueError(f"max_frames {max_frames}: at least 1")
    require_detector(detector)
    watchers = require_observers(observers)
    chosen = options if options is not None else Options(method, **changes)
    opened = opened_source(source, of_source)
    is_named = not isinstance(source, Source)
    findings = gravest(opened) if doctor and is_named else []
    try:
        fields = _core.run(
            opened,
            watchers,
            chosen.method,
            [*chosen.changes, *([] if final_pass else ["window.final_iterations=0"])],
            threads,
            None if output is None else Path(output),
            force,
            max_frames or 0,
            [f"doctor: {finding}" for finding in findings],
            detector,
            loops,
            None if map is None else Path(map),
            None if save_map is None else Path(save_map),
            update_map,
            None if mask is None else visible_pixels(mask, opened.camera.width, opened.camera.height),
        )
    except Error as error:
        raise in_python(error) from error.__cause__
    result = run_from(fields, tuple(findings))
    if result.error is not None:
        result.error.run = result
        raise_cause(result.error, detector, fields["cause"])
    return result
