# SPDX-License-Identifier: MIT
from __future__ import annotations

import json
import shutil
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
    assert text.count("\n  run ") == 1
    for verb in ("run", "demo", "synth", "eval", "report", "bench", "edges", "models", "config", "doctor", "pull", "view"):
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


def test_the_command_runs_a_source_of_python_with_all_flags_of_run(
    sequence: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    bag_recorder = pytest.importorskip("bag_recorder")
    source = edvo.open_source(sequence)
    bag = bag_recorder.record("mcap", tmp_path, source.camera, list(source)[:12])
    flags = ["--start", "2", "--max-frames", "8", "--points", str(tmp_path / "points.ply"), "--json"]
    assert main(["run", str(bag), "-o", str(tmp_path / "out"), *flags]) == 0
    summary = json.loads(capfd.readouterr().out)
    assert summary["frames"]["tracked"] == 8 and summary["frames"]["total"] == 8
    assert summary["evaluation"] is not None
    for name in ("trajectory.tum", "report.html", "summary.json", "frames.jsonl"):
        assert (tmp_path / "out" / name).stat().st_size > 0
    first = json.loads((tmp_path / "out" / "frames.jsonl").read_text().splitlines()[0])
    assert first["index"] == 2 and first["status"] == "first"
    assert (tmp_path / "points.ply").stat().st_size > 0


def test_unknown_words_are_explained_as_the_program_does() -> None:
    assert "did you mean 'doctor'?" in edvo_command("docter").stderr
    assert "did you mean '--depth-topic'?" in edvo_command("run", "x", "--depth-topik", "y").stderr
    result = edvo_command("doctor", "--colour")
    assert result.returncode == 2 and result.stderr.startswith("edvo: ")
    assert "--depth-topic" in edvo_command("run", "--help").stdout
    assert "usage: edvo doctor" in edvo_command("doctor", "--help").stdout
    assert "1280x720" in edvo_command("doctor", "X", "--camera-size", "1280").stderr


def test_topics_of_what_is_no_bag_are_refused(sequence: Path) -> None:
    result = edvo_command("run", str(sequence), "--depth-topic", "/depth")
    assert result.returncode == 2 and "topics are for bags" in result.stderr


def test_ctrl_c_ends_a_run_and_keeps_what_was_done(sequence: Path, tmp_path: Path) -> None:
    code = (
        "import os, signal, sys, edvo\n"
        # A shell starts what runs in its background with SIGINT ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "class Stop(edvo.Observer):\n"
        "    def frame(self, result, image):\n"
        "        if result.stamp_ns > 0: os.kill(os.getpid(), signal.SIGINT)\n"
        "run = edvo.run(sys.argv[1], observers=[Stop()])\n"
        "assert run.interrupted and 0 < run.tracked < 64, run.counts\n"
        "try:\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    import time; time.sleep(1)\n"
        "except KeyboardInterrupt: print('python again')\n"
    )
    command = [sys.executable, "-c", code, str(sequence)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout) == (0, "python again\n"), result.stderr


def completed(*words: str) -> list[str]:
    """What bash offers for the last of the words."""
    script = edvo_command("completion").stdout
    line = " ".join(f"'{word}'" for word in words)
    script += f"\nCOMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _edvo; echo \"${{COMPREPLY[@]}}\"\n"
    result = subprocess.run(["bash"], input=script, capture_output=True, text=True, check=True)
    assert result.stderr == ""
    return result.stdout.split()


def test_bash_completes_verbs_options_and_choices() -> None:
    assert set(completed("edvo", "")) >= {"run", "doctor", "pull", "help", "--version"}
    assert completed("edvo", "dem") == ["demo"]
    assert completed("edvo", "help", "synt") == ["synth"]
    assert completed("edvo", "run", "--max") == ["--max-frames"]
    assert "--depth-topic" in completed("edvo", "run", "--dep")
    assert completed("edvo", "run", "--method", "canny") == ["canny+corner", "canny"]
    assert completed("edvo", "eval", "--format", "mark") == ["markdown"]
    assert "verify" in completed("edvo", "models", "")
    assert completed("edvo", "run", "some-folder") == []  # left to bash: names of files


def test_the_man_page_has_every_option_of_the_help() -> None:
    page = edvo_command("manual").stdout.replace("\\-", "-")
    for verb in ("run", "demo", "synth", "eval", "bench", "edges", "config"):
        text = edvo_command("help", verb).stdout
        assert f"\n.SS {verb}\n" in page
        for word in text.split():
            if word.startswith("--") and word[2:].replace("-", "").isalpha():
                assert word in page, (verb, word)
    assert ".SH EXAMPLES" in page and "edvo run rgbd_dataset_freiburg1_xyz" in page
    if shutil.which("groff"):
        command = ["groff", "-man", "-ww", "-Tutf8"]
        result = subprocess.run(command, input=page, capture_output=True, text=True, check=False)
        assert (result.returncode, result.stderr) == (0, "")


def test_a_reader_that_leaves_is_said_in_one_line() -> None:
    shell = f"{sys.executable} -m edvo pull --list | true; exit ${{PIPESTATUS[0]}}"
    result = subprocess.run(["bash", "-c", shell], capture_output=True, text=True)
    assert result.returncode == 7
    assert result.stderr == "edvo: standard output: cannot write: Broken pipe\n"


def test_help_and_version_are_words_too() -> None:
    assert edvo_command("--version").stdout == f"edvo {edvo.__version__}\n"
    assert edvo_command("help").stdout == edvo_command("--help").stdout
    assert edvo_command("help", "run").stdout == edvo_command("run", "--help").stdout
    assert "Examples:" in edvo_command("--help").stdout
    assert "Examples:" not in edvo_command("run", "--help").stdout
    nothing = edvo_command()
    assert nothing.returncode == 2 and "see edvo --help" in nothing.stderr
    assert "unknown option '--versoin'" in edvo_command("--versoin").stderr
