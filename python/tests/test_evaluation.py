# SPDX-License-Identifier: MIT
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import edvo


def walk(seed: int, count: int = 300) -> edvo.Trajectory:
    """A smooth random path, 30 poses a second."""
    rng = np.random.default_rng(seed)
    positions = np.cumsum(np.cumsum(rng.normal(0, 1e-3, (count, 3)), axis=0) * 0.1, axis=0)
    quaternions = np.array([0, 0, 0, 1]) + np.cumsum(rng.normal(0, 5e-3, (count, 4)), axis=0)
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    stamps = 1_500_000_000_000_000_000 + np.arange(count) * 33_333_000
    return edvo.Trajectory(stamps, np.hstack([positions, quaternions]), 6)


def disturbed(truth: edvo.Trajectory, seed: int) -> edvo.Trajectory:
    rng = np.random.default_rng(seed)
    values = truth.values.copy()
    values[:, :3] += rng.normal(0, 0.01, values[:, :3].shape)
    values[:, 3:] += rng.normal(0, 0.01, values[:, 3:].shape)
    values[:, 3:] /= np.linalg.norm(values[:, 3:], axis=1, keepdims=True)
    keep = rng.random(len(truth)) > 0.1
    return edvo.Trajectory(truth.stamps_ns[keep] + 1_000_000, values[keep], 6)


@pytest.mark.parametrize("seed", range(3))
def test_digits_are_those_of_evo(seed: int, tmp_path: Path) -> None:
    pytest.importorskip("evo")
    from evo.core import metrics, sync
    from evo.tools import file_interface

    truth = walk(seed)
    truth.write(tmp_path / "truth.tum")
    disturbed(truth, seed).write(tmp_path / "estimate.tum")
    reference = file_interface.read_tum_trajectory_file(str(tmp_path / "truth.tum"))
    estimate = file_interface.read_tum_trajectory_file(str(tmp_path / "estimate.tum"))
    reference, estimate = sync.associate_trajectories(reference, estimate, max_diff=0.02)
    rpe = metrics.RPE(metrics.PoseRelation.translation_part, 1, metrics.Unit.frames)
    rpe.process_data((reference, estimate))
    estimate.align(reference)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, estimate))

    ours = edvo.evaluate(tmp_path / "truth.tum", tmp_path / "estimate.tum", protocol="evo")
    for name in ("rmse", "mean", "median", "std", "min", "max"):
        theirs = ape.get_statistic(metrics.StatisticsType[name])
        assert getattr(ours.ate, name) == pytest.approx(theirs, rel=1e-9), name
    assert ours.rpe_translation is not None
    theirs = rpe.get_statistic(metrics.StatisticsType.rmse)
    assert ours.rpe_translation.rmse == pytest.approx(theirs, rel=1e-9)
    assert len(ours.matches) == ape.error.shape[0]


def test_a_perfect_estimate_has_no_error() -> None:
    truth = walk(5)
    result = edvo.evaluate(truth, truth)
    assert result.ate.rmse < 1e-9 and result.coverage == 1
    assert "SE(3)" in result.protocol or "se3" in result.protocol.lower()


def test_no_overlap_is_said() -> None:
    truth = walk(5)
    late = edvo.Trajectory(truth.stamps_ns + 10**12, truth.values)
    with pytest.raises(edvo.Error) as caught:
        edvo.evaluate(truth, late)
    assert caught.value.code == 8


def test_files_are_read_back(tmp_path: Path) -> None:
    truth = walk(1)
    truth.write(tmp_path / "a.tum")
    again = edvo.Trajectory.read(tmp_path / "a.tum")
    assert np.array_equal(again.stamps_ns, truth.stamps_ns)
    assert np.allclose(again.values, truth.values, atol=1e-9)
    truth.write(tmp_path / "a.kitti", "kitti")
    assert np.allclose(np.loadtxt(tmp_path / "a.kitti").reshape(-1, 3, 4), truth.poses[:, :3])
    truth.write(tmp_path / "a.csv", "euroc")
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",")
    assert np.allclose(table[:, 4], truth.quaternions[:, 3])
    with pytest.raises(ValueError, match="tum, kitti, euroc"):
        truth.write(tmp_path / "a", "las")


def test_matrices_and_quaternions_agree() -> None:
    truth = walk(2)
    again = edvo.Trajectory.from_poses(truth.stamps_ns, truth.poses)
    signs = np.sign(np.sum(again.quaternions * truth.quaternions, axis=1, keepdims=True))
    assert np.allclose(again.quaternions * signs, truth.quaternions, atol=1e-9)
