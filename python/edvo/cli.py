# SPDX-License-Identifier: MIT
"""The command ``edvo``: the verbs of the C++ program, and those that need Python."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from edvo import _core
from edvo.errors import Error
from edvo.runner import Observer, Run, run
from edvo.sources import open_source, read_by_core

PYTHON_VERBS = """
Verbs of the Python package:
  run                         also takes ROS bags, RealSense's .bag, phones' recordings
"""


def add_source_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="SOURCE", help="folder, archive, ROS bag or phone's export")
    parser.add_argument("--camera", metavar="FILE", help="calibration of the colour camera")
    parser.add_argument("--depth-scale", type=float, metavar="UNITS", help="depth units per metre")
    parser.add_argument("--depth-camera", metavar="FILE", help="calibration of a depth camera")
    parser.add_argument(
        "--colour-from-depth", metavar="FILE", help="4 x 4 matrix [m], with --depth-camera"
    )
    parser.add_argument("--colour-topic", metavar="TOPIC", help="of a bag")
    parser.add_argument("--depth-topic", metavar="TOPIC", help="of a bag")


def source_options(arguments: argparse.Namespace) -> dict[str, Any]:
    matrix = None
    if arguments.colour_from_depth is not None:
        try:
            matrix = np.loadtxt(arguments.colour_from_depth).reshape(4, 4)
        except (OSError, ValueError) as error:
            raise Error(f"{arguments.colour_from_depth}: no 4 x 4 matrix: {error}", 2) from None
    return {
        "camera": arguments.camera,
        "depth_scale": arguments.depth_scale,
        "depth_camera": arguments.depth_camera,
        "colour_from_depth": matrix,
        "colour_topic": arguments.colour_topic,
        "depth_topic": arguments.depth_topic,
    }


class Progress(Observer):
    """One line on a terminal."""

    def __init__(self) -> None:
        self.count = 0

    def frame(self, result: Any, frame: Any) -> None:
        self.count += 1
        if self.count % 10 == 0:
            print(f"\r{self.count} frames, {result.status}   ", end="", file=sys.stderr)

    def end(self, run: Run) -> None:
        print("\r\x1b[K", end="", file=sys.stderr)


def show(result: Run, as_json: bool) -> None:
    evaluation = result.evaluation
    if as_json:
        summary: dict[str, Any] = {
            "source": result.source,
            "tracked": result.tracked,
            "lost": result.lost,
            "skipped": result.skipped,
            "keyframes": len(result.keyframes),
            "interrupted": result.interrupted,
        }
        if evaluation is not None:
            summary["ate_rmse"] = evaluation.ate.rmse
            summary["protocol"] = evaluation.protocol
        print(json.dumps(summary, indent=2))
        return
    print(f"frames     {result.tracked} tracked, {result.lost} lost, {len(result.skipped)} skipped")
    print(f"keyframes  {len(result.keyframes)}")
    if evaluation is None:
        print(f"no evaluation: {result.no_evaluation}")
        return
    print(f"ATE        {evaluation.ate.rmse:.5f} m")
    if evaluation.rpe_translation is not None and evaluation.rpe_rotation is not None:
        print(
            f"RPE        {evaluation.rpe_translation.rmse:.5f} m/s, "
            f"{evaluation.rpe_rotation.rmse:.5f} deg/s"
        )
    print(evaluation.protocol)


def run_source(words: list[str]) -> int:
    parser = argparse.ArgumentParser("edvo run", description="Tracks a recording.")
    add_source_flags(parser)
    parser.add_argument("--method", default=_core.default_method)
    parser.add_argument("--set", action="append", default=[], metavar="group.field=value")
    parser.add_argument("--max-frames", type=int, metavar="N")
    parser.add_argument("-o", "--output", metavar="DIR", help="folder for the trajectories")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quiet", action="store_true")
    arguments = parser.parse_args(words)
    source = open_source(arguments.source, **source_options(arguments))
    if not arguments.quiet:
        print(f"sequence  {source.origin}", file=sys.stderr)
        for note in source.notes:
            print(f"note: {note}", file=sys.stderr)
    for warning in source.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    changes = dict(text.partition("=")[::2] for text in arguments.set)
    observers: list[Observer] = []
    if not arguments.quiet and sys.stderr.isatty():
        observers.append(Progress())
    result = run(
        source,
        method=arguments.method,
        observers=observers,
        max_frames=arguments.max_frames,
        **{name: literal(value) for name, value in changes.items()},
    )
    show(result, arguments.json)
    folder = Path(arguments.output or Path("runs") / source.name)
    result.write(folder)
    if not arguments.json:
        print(f"\nwritten to {folder}")
    if result.interrupted:
        return 130
    if result.tracked == 0:
        raise Error(f"{source.origin}: none of {len(result.frames)} frames could be tracked", 9)
    return 0


def literal(text: str) -> bool | int | float | str:
    if text in ("true", "false"):
        return text == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def source_in(words: list[str]) -> str | None:
    """The first word that is a file or a folder."""
    return next((word for word in words if word[:1] != "-" and Path(word).exists()), None)


def dispatch(words: list[str]) -> int:
    if words[:1] == ["run"]:
        source = source_in(words[1:])
        own_flags = ("--depth-camera", "--colour-topic", "--depth-topic", "--colour-from-depth")
        wants_python = any(word.split("=")[0] in own_flags for word in words)
        if wants_python or (source is not None and not read_by_core(source)):
            return run_source(words[1:])
    status = int(_core.main(["edvo", *words]))
    if words in (["--help"], ["-h"]):
        print(PYTHON_VERBS, end="")
    return status


def main(arguments: list[str] | None = None) -> int:
    """Runs ``edvo ARGUMENTS`` and returns its exit status (docs/errors.md)."""
    try:
        return dispatch(sys.argv[1:] if arguments is None else arguments)
    except Error as error:
        print(f"edvo: {error}", file=sys.stderr)
        return error.code
    except BrokenPipeError:
        return 1
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
