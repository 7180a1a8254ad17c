# SPDX-License-Identifier: MIT
# %% [markdown]
# # edvo in a notebook
# Open this file in VS Code, Spyder or Jupyter (jupytext): each `# %%` begins a cell. It needs no data:
# the first cell renders a room with a Kinect-like camera and exact ground truth.

# %%
import numpy as np

import edvo
from edvo.cli import main

main(["synth", "office", "--frames", "90", "--size", "320x240"])
source = edvo.open_source("office")  # a folder, an archive, a bag, a phone's recording
print(source.origin, *source.notes, sep="\n")

# %% [markdown]
# ## Is the recording all right?

# %%
for finding in edvo.diagnose(source, motion_too=False):
    print(f"{finding.verdict:8} {finding}")

# %% [markdown]
# ## The whole recording at once
# What `edvo run office` does, to the same bits.

# %%
run = edvo.run(source)
print(run.counts)
print(f"ATE {run.evaluation.ate.rmse:.4f} m, {len(run.keyframes)} keyframes, {len(run.links)} links looked at")

# %%
try:
    import matplotlib.pyplot as plt
except ImportError:
    plt = None  # pip install matplotlib
if plt:
    aligned = run.evaluation.truth_from_estimate
    path = run.trajectory.positions @ aligned[:3, :3].T + aligned[:3, 3]
    figure, axes = plt.subplots(1, 2, figsize=(10, 4))
    axes[0].plot(*source.ground_truth.positions[:, [0, 2]].T, "k-", label="ground truth")
    axes[0].plot(*path[:, [0, 2]].T, label="edvo")
    axes[0].set(xlabel="x [m]", ylabel="z [m]", aspect="equal")
    axes[0].legend()
    axes[1].plot([frame.inlier_ratio for frame in run.frames])
    axes[1].set(xlabel="frame", ylabel="share of inliers")
    figure.savefig("office.png")

# %% [markdown]
# ## Image by image
# With a camera of your own the loop is the same: seconds, H x W x 3 `uint8`, H x W `float32` in metres.

# %%
slam = edvo.Slam(source.camera)
for frame in source:
    result = slam.process_ns(frame.stamp_ns, frame.decimals, frame.rgb, frame.depth)
slam.finish()  # joins segments, closes loops, refines all keyframes
print(result.status, result.pose[:3, 3])
sigma = np.sqrt(np.diag(np.linalg.inv(result.information)))
print(f"last frame against its keyframe: {1000 * sigma[:3].max():.2f} mm, {np.degrees(sigma[3:].max()):.3f} deg")
assert np.array_equal(slam.trajectory().values, run.trajectory.values)

# %% [markdown]
# ## Edges of your own

# %%
class Gradients(edvo.EdgeDetector):
    def strength(self, rgb):
        dy, dx = np.gradient(rgb.astype(np.float32).mean(axis=2))
        return np.clip(np.hypot(dx, dy) / 32, 0, 1)


own = edvo.run(source, detector=Gradients())
print(f"ATE {own.evaluation.ate.rmse:.4f} m")

# %% [markdown]
# ## Files for others

# %%
run.trajectory.write("office.tum")
run.trajectory.write("office_kitti.txt", format="kitti")
print(edvo.evaluate("office/groundtruth.txt", "office.tum").protocol)
