# SPDX-License-Identifier: MIT
from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def test_the_notebook_runs_from_its_first_cell_to_its_last(tmp_path: Path) -> None:
    notebook = Path(__file__).parents[2] / "examples" / "04_notebook.py"
    command = [sys.executable, "-W", "error", str(notebook)]
    result = subprocess.run(
        command,
        cwd=tmp_path,
        env={"MPLBACKEND": "Agg", "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "tum" in result.stdout.lower() and "tracked" in result.stdout
    assert (tmp_path / "office.tum").stat().st_size > 0
    assert (tmp_path / "office_kitti.txt").stat().st_size > 0
