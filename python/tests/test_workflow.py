# SPDX-License-Identifier: MIT
"""workflow/: twenty sequences, of which one fails and one is killed on the way."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import synth

pytest.importorskip("snakemake")

WORKFLOW = Path(__file__).parents[2] / "workflow"
PROGRAM = os.environ.get("EDVO_PROGRAM") or f"{sys.executable} -m edvo"


def snakemake(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "snakemake", "-s", str(WORKFLOW / "Snakefile"), *arguments]
    command += ["--config", f"data=['{folder}/data/*']", f"edvo={folder}/edvo", "threads=1"]
    command += ["arguments=--no-report"]
    environment = os.environ | {"XDG_CACHE_HOME": str(folder / "cache")}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def table(folder: Path) -> dict[str, dict[str, str]]:
    with (folder / "runs" / "table.csv").open(encoding="utf-8") as stream:
        return {row["sequence"]: row for row in csv.DictReader(stream)}


@pytest.fixture
def fleet(tmp_path: Path) -> Path:
    (tmp_path / "data").mkdir()
    for i in range(3):
        made = synth(tmp_path / f"made{i}", "--frames", "8", "--seed", str(i))
        for name in (f"{k:02}" for k in range(i, 18, 3)):
            (tmp_path / "data" / name).symlink_to(made)
    (tmp_path / "data" / "killed").symlink_to(tmp_path / "made0")
    (tmp_path / "data" / "broken").mkdir()
    program = tmp_path / "edvo"
    program.write_text(
        "#!/bin/sh\n"
        f"echo $2 >> {tmp_path}/calls\n"
        f"case $2 in */killed) [ -e {tmp_path}/again ] || kill -9 $$ ;; esac\n"
        f"exec {PROGRAM} \"$@\"\n",
        encoding="utf-8",
    )
    program.chmod(0o755)
    return tmp_path


def test_what_fails_stops_no_other_and_is_tried_again(fleet: Path) -> None:
    first = snakemake(fleet)
    assert first.returncode == 1, first.stderr
    rows = table(fleet)
    assert len(rows) == 20 and sum(row["state"] == "done" for row in rows.values()) == 18
    assert rows["00"]["tracked"] == "8" and float(rows["00"]["ate_m"]) < 0.02
    assert rows["broken"]["state"] == "failed" and "broken" in rows["broken"]["note"]
    assert rows["killed"]["state"] == "failed"

    (fleet / "calls").unlink()
    (fleet / "again").touch()
    (fleet / "data" / "broken").rmdir()
    (fleet / "data" / "broken").symlink_to(fleet / "made1")
    second = snakemake(fleet)
    assert second.returncode == 0, second.stderr
    called = (fleet / "calls").read_text().split()
    assert sorted(Path(path).name for path in called) == ["broken", "killed"]
    assert all(row["state"] == "done" for row in table(fleet).values())
    assert "| killed | done |" in (fleet / "runs" / "table.md").read_text()


def test_no_sequence_is_an_error(tmp_path: Path) -> None:
    result = snakemake(tmp_path)
    assert result.returncode == 1 and "no sequence" in result.stderr + result.stdout
