# SPDX-License-Identifier: MIT
"""Errors of a trajectory against ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from edvo import _core
from edvo.trajectory import Trajectory


@dataclass(frozen=True)
class Statistics:
    """Of a set of errors, in their unit; ``std`` is the population's."""

    rmse: float
    mean: float
    median: float
    std: float
    min: float
    max: float


@dataclass(frozen=True, eq=False)
class Evaluation:
    """ATE, RPE and drift, with the protocol that they follow."""

    protocol: str  # association, alignment and delta, as one line
    matches: NDArray[np.int64]  # N x 2, indices into ground truth and estimate
    coverage: float  # [0..1]
    ate: Statistics  # [m]
    ate_errors: NDArray[np.float64]  # one per match [m]
    scale: float  # found with align="sim3", else 1
    truth_from_estimate: NDArray[np.float64]  # 4 x 4
    rpe_pairs: int
    rpe_translation: Statistics | None  # over delta [m]; None without pairs
    rpe_rotation: Statistics | None  # over delta [deg]
    drift_metres: float  # of the end, first matched poses laid on each other [m]
    drift_percent: float | None  # of the path; None where the ground truth stands still
    warnings: list[str]


def evaluate(
    truth: Trajectory | str | Path,
    estimate: Trajectory | str | Path,
    *,
    align: str = "se3",
    protocol: str = "tum",
    delta: str | None = None,
    max_difference: float = 0.02,
    offset: float = 0.0,
    max_pairs: int = 10000,
    seed: int = 0,
    frames: int = 0,
) -> Evaluation:
    """Compares an estimate with ground truth, as ``edvo eval`` does.

    ``align``: "se3", "sim3" or "none". ``protocol``: "tum" (the benchmark's scripts) or "evo".
    ``delta`` of the RPE: "1s" (TUM's default), "30f", "0.5m", "10deg" or "all"; evo's is "1f".
    ``max_difference`` and ``offset`` of the stamps in seconds. ``frames``: images that the estimate
    was made from, for the coverage. Raises ``edvo.Error`` (code 8) where the two cannot be compared.
    """
    a, b = (t if isinstance(t, Trajectory) else Trajectory.read(t) for t in (truth, estimate))
    if delta is None:
        delta = "1f" if protocol == "evo" else "1s"
    fields: dict[str, Any] = _core.evaluate(
        a.stamps_ns,
        a.values,
        a.segments,
        b.stamps_ns,
        b.values,
        b.segments,
        align,
        protocol,
        delta,
        max_difference,
        offset,
        max_pairs,
        seed,
        frames,
    )
    for name in ("ate", "rpe_translation", "rpe_rotation"):
        if fields[name] is not None:
            fields[name] = Statistics(**fields[name])
    return Evaluation(**fields)
