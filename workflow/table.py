#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""One table of many runs: table.csv and table.md in their folder.

    workflow/table.py RUNS NAME...

A sequence without a summary is a row too, with the last line of its log.
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

COLUMNS = (
    "sequence", "state", "frames", "tracked", "lost", "segments", "keyframes", "coverage",
    "ate_m", "rpe_m_per_s", "rpe_deg_per_s", "ms_median", "warnings", "note",
)  # fmt: skip


def last_line(file: Path) -> str:
    if not file.is_file():
        return "has not run"
    lines = file.read_text(encoding="utf-8", errors="replace").split("\n")
    said = [line.strip() for line in lines if line.strip()]
    return said[-1] if said else "ended without a word (killed?)"


def row_of(runs: Path, name: str) -> dict[str, object]:
    row: dict[str, object] = dict.fromkeys(COLUMNS, "")
    row["sequence"] = name
    file = runs / name / "summary.json"
    if not file.is_file():
        row["note"] = last_line(runs / "logs" / f"{name}.log")
        row["state"] = "missing" if row["note"] == "has not run" else "failed"
        return row
    summary = json.loads(file.read_text(encoding="utf-8"))
    frames, evaluation = summary["frames"], summary["evaluation"]
    row |= {
        "state": "done",
        "frames": frames["total"],
        "tracked": frames["tracked"],
        "lost": frames["lost"],
        "segments": summary["segments"],
        "keyframes": summary["keyframes"],
        "coverage": round(summary["coverage"], 4),
        "ms_median": round(summary["ms"]["total"]["median"], 2),
        "warnings": len(summary["warnings"]),
    }
    if evaluation is not None:
        errors = evaluation["final"]
        row["ate_m"] = rounded(errors["ate_rmse_m"])
        row["rpe_m_per_s"] = rounded(errors["rpe_translation_rmse_m_per_s"])
        row["rpe_deg_per_s"] = rounded(errors["rpe_rotation_rmse_deg_per_s"])
    return row


def rounded(value: float | None) -> float | str:
    return "" if value is None else round(value, 5)


def main() -> int:
    runs, names = Path(sys.argv[1]), sys.argv[2:]
    rows = [row_of(runs, name) for name in names]
    runs.mkdir(parents=True, exist_ok=True)
    with (runs / "table.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    lines = ["| " + " | ".join(COLUMNS) + " |", "| --- " * len(COLUMNS) + "|"]
    for row in rows:
        cells = (str(row[column]).replace("|", "\\|") for column in COLUMNS)
        lines.append("| " + " | ".join(cells) + " |")
    (runs / "table.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    done = sum(row["state"] == "done" for row in rows)
    print(f"{done} of {len(rows)} sequences done: {runs / 'table.md'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
