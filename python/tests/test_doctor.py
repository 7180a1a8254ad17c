# SPDX-License-Identifier: MIT
"""Each fault planted in good sequences is found and named; good ones have none."""

from __future__ import annotations

import json
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
