# SPDX-License-Identifier: MIT
from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import edvo
from edvo.cli import main


def edvo_command(*arguments: str, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "edvo", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)  # type: ignore[call-overload,no-any-return]


def test_all_verbs_of_the_program_are_there() -> None:
    text = edvo_command("--help").stdout
    for verb in ("run", "demo", "synth", "eval", "bench", "edges", "models", "config"):
        assert f"\n  {verb} " in text, verb


def test_exit_statuses_are_the_programs() -> None:
    result = edvo_command("rum")
    assert result.returncode == 2 and "edvo: " in result.stderr
    assert edvo_command("run", "/nonexistent").returncode == 3


def test_a_missing_extra_gives_one_sentence_with_the_command(tmp_path: Path) -> None:
    (tmp_path / "x.bag").write_bytes(b"#ROSBAG V2.0\n")
    hide = "import sys; sys.modules['rosbags'] = None; sys.modules['rosbags.highlevel'] = None\n"
    run = "from edvo.cli import main; sys.exit(main(['run', sys.argv[1]]))"
    command = [sys.executable, "-c", hide + run, str(tmp_path / "x.bag")]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr == (
        "edvo: reading x.bag needs the package rosbags: pip install 'edvo[ros]'\n"
    )


def test_the_command_runs_a_source_of_python(
    sequence: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    test_bags = pytest.importorskip("test_bags")
    source = edvo.open_source(sequence)
    bag = test_bags.record("mcap", tmp_path, source.camera, list(source)[:8])
    assert main(["run", str(bag), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    assert "8 tracked, 0 lost" in capsys.readouterr().out
    assert len(edvo.Trajectory.read(tmp_path / "out" / "trajectory.tum")) == 8
