# SPDX-License-Identifier: MIT
"""One thing that is fuzzed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Target:
    test: Callable[[bytes, Path], None]  # of an input, in an empty folder; raises if anything is wrong
    seeds: Callable[[Path], list[bytes]]  # inputs to begin with, made in an empty folder
