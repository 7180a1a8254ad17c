# SPDX-License-Identifier: MIT
"""Each fault planted in good sequences is found and named; good ones have none."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from conftest import synth
from planted import FAULTS, Fault, Memory, findings_of

import edvo
from edvo.cli import main
from edvo.doctor import gravest
from edvo.sources import FolderSource

SCENES = ("office", "living_room")  # benchmarks/doctor.py takes any sequences


@pytest.fixture(scope="module", params=SCENES)
def good(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Memory:
    folder = synth(
        tmp_path_factory.mktemp("doctor") / request.param,
        "--scene", request.param, "--frames", "64", "--seed", "3",
    )  # fmt: skip
    source = FolderSource(folder)
    return Memory(source.camera, list(source), source.ground_truth)


def test_a_good_sequence_has_no_fault(good: Memory) -> None:
    assert findings_of(good, with_motion=True) == set()


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_planted_fault_is_named(good: Memory, fault: Fault) -> None:
    assert fault.finding in findings_of(fault.plant(good), fault.needs_truth)


def finding_of(source: edvo.Source, fault: str) -> edvo.Finding:
    return next(f for f in edvo.diagnose(source, motion_too=False) if f.fault == fault)


def slower(good: Memory, stride: int, late: int) -> Memory:
    """Every ``stride``-th frame, with the depth of ``late`` frames before."""
    pairs = zip(good.list[late::stride], good.list[::stride])
    return Memory(good.camera, [replace(a, depth=b.depth) for a, b in pairs])


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> Memory:
    flags = ("--scene", "office", "--frames", "200", "--seed", "3")
    source = FolderSource(synth(tmp_path_factory.mktemp("doctor") / "long", *flags))
    return Memory(source.camera, list(source))


def test_depth_late_by_part_of_a_period_is_no_fault(long: Memory) -> None:
    """As a Kinect's depth is, by 20 ms; the offset is measured between frames."""
    finding = finding_of(slower(long, stride=3, late=2), "time_offset")
    assert finding.verdict == "ok" and "+75 ms from colour" in finding.measured


def test_stamps_of_depth_count_for_its_offset(long: Memory) -> None:
    late = slower(long, stride=5, late=4)
    assert finding_of(late, "time_offset").verdict == "fault"
    late.depth_delay_ns = -100_000_000
    assert finding_of(late, "time_offset").verdict == "ok"


def panned(good: Memory, late: int) -> Memory:
    """A camera that turns one way, 4 px a frame, with depth of earlier frames."""
    wide, width = good.list[0], 224
    frames = [
        replace(
            good.list[i],
            rgb=wide.rgb[:, 4 * i : 4 * i + width],
            depth=wide.depth[:, 4 * (i - late) : 4 * (i - late) + width],
        )
        for i in range(late, 24)
    ]
    return Memory(replace(good.camera, width=width), frames)


def test_late_depth_of_a_camera_that_moves_one_way_is_not_called_unregistered(good: Memory) -> None:
    assert finding_of(panned(good, late=0), "registration").verdict == "ok"
    late = panned(good, late=1)
    assert finding_of(late, "registration").verdict == "ok"


def test_single_frames_dropped_at_the_start_of_a_short_recording_are_no_fault(good: Memory) -> None:
    dropped = [frame for i, frame in enumerate(good.list[:40]) if i not in (2, 5, 9, 14, 20, 27)]
    assert finding_of(Memory(good.camera, dropped), "frame_gaps").verdict == "ok"


def test_a_mirror_cannot_be_seen_without_ground_truth(good: Memory) -> None:
    found = edvo.diagnose(Memory(good.camera, good.list))
    (finding,) = [f for f in found if f.fault == "mirrored"]
    assert finding.verdict == "unknown" and "residuals alone cannot tell" in finding.measured


def test_the_command_prints_and_has_a_status(
    sequence: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", str(sequence), "--no-tracking"]) == 0
    assert "no fault found" in capsys.readouterr().out
    arguments = ["doctor", str(sequence), "--no-tracking", "--json", "--depth-scale", "100"]
    assert main(arguments) == 1
    report = json.loads(capsys.readouterr().out)
    first = report["findings"][0]
    assert first["fault"] == "depth_scale" and "--depth-scale 5000" in first["advice"]
    assert report["faults"] >= 1


def test_a_run_says_the_gravest_faults_first_and_goes_on(
    sequence: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "out")
    flags = ["run", str(sequence), "-o", out, "--force", "--quiet", "--max-frames", "8"]
    assert main([*flags, "--depth-scale", "1000"]) == 0
    said = capfd.readouterr().err
    assert "warning: doctor: depth_scale: median depth" in said and "--depth-scale 5000" in said
    assert said.count("warning: doctor: ") <= 4
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert any("doctor: depth_scale" in warning for warning in summary["warnings"])
    assert "doctor: depth_scale" in (tmp_path / "out" / "report.html").read_text()
    assert main([*flags, "--depth-scale", "1000", "--no-doctor"]) == 0
    assert "doctor" not in capfd.readouterr().err
    assert main(flags) == 0
    assert "doctor" not in capfd.readouterr().err


def test_run_returns_the_gravest_faults(sequence: Path) -> None:
    scaled = {"depth_scale": 1000.0}
    run = edvo.run(sequence, max_frames=4, source_options=scaled)
    assert [finding.fault for finding in run.findings][0] == "depth_scale"
    assert edvo.run(sequence, max_frames=4, source_options=scaled, doctor=False).findings == ()
    assert edvo.run(sequence, max_frames=4).findings == ()


def test_the_look_before_a_run_has_no_false_alarm_and_ends_no_run(good: Memory) -> None:
    assert gravest(good) == []

    class Broken(Memory):
        def __iter__(self):  # type: ignore[no-untyped-def]
            raise edvo.Error("the disk is gone", 3)

    assert gravest(Broken(good.camera, good.list)) == []
