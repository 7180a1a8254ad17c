# SPDX-License-Identifier: MIT
"""The command ``edvo``: the C++ program with Python's sources, viewer and verbs."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from edvo import _core
from edvo.errors import Error
from edvo.observer import Observer
from edvo.sources import Source, open_source, read_by_core

FAULTS_FOUND = 1  # exit status of doctor
Option = tuple[str, str, str]  # name, type of its value ("" = a flag), help

SOURCE_OPTIONS: list[Option] = [
    ("--depth-camera", "FILE", "Calibration of a depth camera that is not registered to colour"),
    ("--colour-from-depth", "FILE", "4 x 4 matrix [m], with --depth-camera"),
    ("--colour-topic", "TOPIC", "Of a bag; else guessed"),
    ("--depth-topic", "TOPIC", "Of a bag; else guessed"),
]
NO_DOCTOR: Option = ("--no-doctor", "", "Do not look at the recording for the usual faults first")
WATCH_OPTIONS: list[Option] = [
    ("--view", "", "Show the run in Rerun: a window, or without a display a browser page"),
    ("--record", "FILE.rrd", "Record the run for Rerun"),
    ("--mcap", "FILE.mcap", "Write images, poses and points as a ROS 2 recording"),
]


class Parser(argparse.ArgumentParser):
    """Says what is wrong as the program does."""

    def error(self, message: str) -> NoReturn:
        raise Error(f"{message}; see {self.prog} --help", 2)


def source_options(values: dict[str, str]) -> dict[str, Any]:
    """Of ``open_source``, from what stands on the command line."""
    matrix = None
    if file := values.get("--colour-from-depth"):
        try:
            matrix = np.loadtxt(file).reshape(4, 4)
        except (OSError, ValueError) as error:
            raise Error(f"{file}: no 4 x 4 matrix: {error}", 2) from None
    return {
        "depth_camera": values.get("--depth-camera"),
        "colour_from_depth": matrix,
        "colour_topic": values.get("--colour-topic"),
        "depth_topic": values.get("--depth-topic"),
    }


class Host:
    """What the C++ program asks Python for; see apps/edvo/extension.hpp."""

    source_options = [*SOURCE_OPTIONS, NO_DOCTOR]
    watch_options = WATCH_OPTIONS

    def __init__(self) -> None:
        self._opened: Source | None = None
        self.verbs: list[tuple[str, str, Callable[[list[str]], int]]] = [
            ("doctor", "Measure the usual faults of a recording and say what mends them", verb(doctor)),
            ("export", "Write a trajectory as TUM, KITTI, EuRoC or MCAP", verb(export)),
            ("pull", "Download a public sequence or DexiNed into the cache", verb(pull)),
            ("view", "Show a finished run in Rerun", verb(view)),
        ]

    def open_source(
        self,
        path: str,
        camera: str | None,
        camera_size: tuple[int, int],
        depth_scale: float | None,
        values: dict[str, str],
    ) -> Source | None:
        """None: the C++ library opens it, or says why not."""
        if read_by_core(path) and not any(name in values for name, _, _ in SOURCE_OPTIONS):
            return None
        self._opened = open_source(
            path,
            camera=camera,
            camera_size=camera_size,
            depth_scale=depth_scale,
            **source_options(values),
        )
        return self._opened

    def examine(
        self,
        path: str,
        camera: str | None,
        camera_size: tuple[int, int],
        depth_scale: float | None,
        values: dict[str, str],
    ) -> list[str]:
        """What the doctor finds grave in a recording that has been opened."""
        from edvo.doctor import gravest

        if "--no-doctor" in values:
            return []
        source = self._opened or open_source(
            path, camera=camera, camera_size=camera_size, depth_scale=depth_scale
        )
        findings = [f"doctor: {finding}" for finding in gravest(source)]
        if findings:
            findings.append("doctor: edvo doctor tells more; --no-doctor leaves this out")
        return findings

    def pull(self, name: str) -> str:
        """Where a public sequence is, downloaded if it is missing."""
        from edvo import pulling

        print(f"edvo: {name}", file=sys.stderr, flush=True)
        return str(pulling.pull(name))

    def make_observers(self, values: dict[str, str]) -> list[Observer]:
        observers: list[Observer] = []
        for option, ending in WRITTEN.items():
            if option in values:
                require_output(option, values[option], ending, "--force" in values)
        if "--record" in values and same_place(values["--record"], values.get("--mcap")):
            raise Error(f"--mcap {values['--mcap']}: --record writes that file; give another name", 2)
        if "--view" in values or "--record" in values:
            from edvo.view import RerunObserver

            observers.append(RerunObserver(values.get("--record"), live="--view" in values))
        if file := values.get("--mcap"):
            from edvo.mcap_file import McapObserver

            observers.append(McapObserver(file))
        return observers


def verb(function: Callable[[list[str]], int]) -> Callable[[list[str]], int]:
    """With ctrl-C as in Python, and argparse's exits as a status."""

    def call(words: list[str]) -> int:
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            status = function(words)
            sys.stdout.flush()
            return status
        except SystemExit as leave:
            sys.stdout.flush()
            return leave.code if isinstance(leave.code, int) else 0
        except KeyboardInterrupt:
            return 130
        except BrokenPipeError as error:
            # What is left to print goes nowhere, or the interpreter would complain at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise Error(f"standard output: cannot write: {error.strerror}", 7) from None
        finally:
            signal.signal(signal.SIGINT, before)

    return call


def require_new(option: str, file: str | Path, force: bool) -> None:
    """As the program has it: without ``--force`` no file is replaced, but for an empty one."""
    place = Path(file)
    if not force and place.is_file() and place.stat().st_size > 0:
        raise Error(
            f"{option} {file}: there is such a file; give another name, or replace it with --force", 7
        )


WRITTEN = {"--record": ".rrd", "--mcap": ".mcap"}  # by option, with the ending


def require_output(option: str, file: str | Path, ending: str, force: bool) -> None:
    """As the program has it: before hours of work, not after them."""
    place = Path(file)
    if place.suffix and place.suffix.lower() != ending:
        raise Error(f"{option} {file}: {place.suffix} is not written here, only {ending}", 2)
    if place.is_dir():
        raise Error(f"{option} {file}: is a folder; give the name of a file", 7)
    if not place.parent.is_dir():
        raise Error(f"{option} {file}: there is no folder {place.parent}", 7)
    require_new(option, file, force)


def same_place(one: str, other: str | None) -> bool:
    return other is not None and Path(one).resolve() == Path(other).resolve()


def width_and_height(text: str) -> tuple[int, int]:
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text}: WIDTHxHEIGHT is expected, such as 1280x720")
    return int(width), int(height)


def add_source_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="SOURCE", help="folder, archive, bag, phone's recording or camera:KIND")
    parser.add_argument("--camera", metavar="FILE", help="calibration of the colour camera")
    parser.add_argument(
        "--camera-size", type=width_and_height, default=(0, 0), metavar="WxH",
        help="of the images that the calibration is for, if they were resized",
    )  # fmt: skip
    parser.add_argument("--depth-scale", type=float, metavar="UNITS", help="depth units per metre")
    for name, kind, text in SOURCE_OPTIONS:
        parser.add_argument(name, metavar=kind, help=text)


def open_named(arguments: argparse.Namespace) -> Source:
    """The source of add_source_arguments()."""
    values = {
        name: getattr(arguments, name[2:].replace("-", "_")) for name, _, _ in SOURCE_OPTIONS
    }
    given = {name: value for name, value in values.items() if value is not None}
    return open_source(
        arguments.source,
        camera=arguments.camera,
        camera_size=arguments.camera_size,
        depth_scale=arguments.depth_scale,
        **source_options(given),
    )


def doctor(words: list[str]) -> int:
    from edvo.doctor import diagnose

    parser = Parser("edvo doctor", description="Measures the usual faults of a recording.")
    add_source_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--no-tracking", action="store_true", help="do not track: leaves out the mirrored image"
    )
    arguments = parser.parse_args(words)
    source = open_named(arguments)
    findings = diagnose(source, motion_too=not arguments.no_tracking)
    faults = [finding for finding in findings if finding.verdict == "fault"]
    if arguments.json:
        report = {
            "source": source.origin,
            "camera": source.camera_origin,
            "faults": len(faults),
            "findings": [finding.to_dict() for finding in findings],
        }
        print(json.dumps(report, indent=2))
        return FAULTS_FOUND if faults else 0
    for note in source.notes:
        print(f"note: {note}", file=sys.stderr)
    for finding in faults:
        print(f"FAULT    {finding.fault}: {finding.measured}\n         {finding.advice}")
    for finding in findings:
        if finding.verdict != "fault":
            print(f"{finding.verdict:<8} {finding.fault}: {finding.measured}")
    count = f"{len(faults)} fault{'' if len(faults) == 1 else 's'} found" if faults else "no fault found"
    print(f"{source.name}: {count}")
    return FAULTS_FOUND if faults else 0


def pull(words: list[str]) -> int:
    from edvo import pulling

    parser = Parser(
        "edvo pull",
        description="Downloads public sequences and models into the cache, checks them, and goes on "
        "where it was stopped.",
    )
    parser.add_argument("name", nargs="?", metavar="NAME", help="none: list what is known")
    parser.add_argument("--list", action="store_true", help="list what is known and what is there")
    parser.add_argument("--url", help="take this address")
    parser.add_argument("--timeout", type=float, default=30, metavar="SECONDS")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    arguments = parser.parse_args(words)
    if arguments.list or arguments.name is None:
        for line in pulling.listing():
            print(line)
        return 0
    place = pulling.pull(
        arguments.name, url=arguments.url, timeout=arguments.timeout, quiet=arguments.quiet
    )
    print(place)
    return 0


def export(words: list[str]) -> int:
    from edvo.trajectory import FORMATS, Trajectory, format_of

    parser = Parser(
        "edvo export", description="Writes a run's trajectory, or a file's, in another format."
    )
    parser.add_argument("source", metavar="RUN|FILE", help="a run's folder or a trajectory file")
    parser.add_argument("file", metavar="OUT", help="the file to write")
    parser.add_argument(
        "--format", choices=FORMATS, help="default: as OUT ends, .tum, .txt, .kitti, .csv or .mcap"
    )
    parser.add_argument("--force", action="store_true", help="replace a file that is there")
    arguments = parser.parse_args(words)
    chosen = arguments.format or format_of(arguments.file)
    require_new("export", arguments.file, arguments.force)
    trajectory = Trajectory.read(arguments.source)
    segments = len(set(trajectory.segments.tolist()))
    if chosen != "tum" and segments > 1:
        print(
            f"warning: {arguments.source}: {segments} segments, between which no motion is known; "
            f"{arguments.file} does not tell them apart, a .tum file does",
            file=sys.stderr,
        )
    trajectory.write(arguments.file, format=chosen)
    return 0


def view(words: list[str]) -> int:
    parser = Parser("edvo view", description="Shows a finished run in Rerun.")
    parser.add_argument("run", metavar="RUN", help="folder that edvo run wrote, or its .rrd file")
    parser.add_argument("--record", metavar="FILE.rrd", help="write a file instead of showing it")
    parser.add_argument("--force", action="store_true", help="replace a recording that is there")
    arguments = parser.parse_args(words)
    is_recording = Path(arguments.run).suffix == ".rrd"
    if arguments.record is not None:
        if is_recording:
            raise Error(f"--record {arguments.record}: {arguments.run} is such a recording already", 2)
        require_output("--record", arguments.record, WRITTEN["--record"], arguments.force)
    from edvo.view import show_file, show_run

    if is_recording:
        show_file(Path(arguments.run))
    else:
        show_run(Path(arguments.run), arguments.record)
    return 0


SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE, signal.SIGXFSZ)


def main(arguments: list[str] | None = None) -> int:
    """Runs ``edvo ARGUMENTS`` and returns its exit status (docs/errors.md).

    Signals are the program's meanwhile; call it in the main thread.
    """
    words = sys.argv[1:] if arguments is None else arguments
    before = {number: signal.getsignal(number) for number in SIGNALS}
    sys.stdout.flush()
    try:
        return int(_core.main(["edvo", *words], Host()))
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


if __name__ == "__main__":
    sys.exit(main())
