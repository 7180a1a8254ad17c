# SPDX-License-Identifier: MIT
"""What the doctor says about one fault."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Finding:
    fault: str  # short name, stable: "depth_scale"
    verdict: str  # "ok", "fault" or "unknown" (there was nothing to measure it on)
    measured: str  # the value with its unit
    advice: str = ""  # the flag or the step that mends it
    gravity: int = 1  # 3: no result can be right, 2: large errors, 1: worth a look

    def to_dict(self) -> dict[str, Any]:
        return asdict(self)

    def __str__(self) -> str:
        return f"{self.fault}: {self.measured}" + (f"; {self.advice}" if self.advice else "")


def ok(fault: str, measured: str) -> Finding:
    return Finding(fault, "ok", measured, gravity=0)


def unknown(fault: str, why: str) -> Finding:
    return Finding(fault, "unknown", why, gravity=0)
