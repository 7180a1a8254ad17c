# SPDX-License-Identifier: MIT
"""Share of edge pixels found again within 1 pixel in another view, at equal edge density.

Edges of one image, lifted by the true depth, moved by the true poses and projected, are looked for
among the edges of the image some frames later. Every detector keeps the same share of the pixels of
each image by a threshold on the gradient: for networks on the gradient times the square root of the
strength, as edvo uses them. Pixels at jumps of depth, without depth, hidden in the other view or
outside of it are left out.

python3 training/repeatability.py SEQUENCE canny models/edvo_edges.toml [--density 0.04]
"""
import argparse
import json
from pathlib import Path

import cv2
import numpy as np

import detectors

# fx, fy, cx, cy, and the distortion k1, k2, p1, p2, k3
CAMERAS = {"freiburg1": ((517.3, 516.5, 318.6, 255.3), (0.2624, -0.9531, -0.0054, 0.0026, 1.1633)),
           "synth": ((525.0, 525.0, 319.5, 239.5), None)}
JUMP = 0.04  # of depth, between neighbours
HIDDEN = 0.05  # of depth: what lies this much nearer in the other view hides the point
ASSOCIATION = 0.02  # [s]


def rows(path):
    lines = [l.split() for l in Path(path).read_text().splitlines() if l and not l.startswith("#")]
    return [(float(l[0]), l[1:]) for l in lines]


def nearest(table, time):
    index = int(np.argmin(np.abs(np.array([t for t, _ in table]) - time)))
    return table[index][1] if abs(table[index][0] - time) <= ASSOCIATION else None


def between(table, time):
    """The pose at this time, between the two that were measured before and after it."""
    after = int(np.searchsorted([t for t, _ in table], time))
    if after == 0 or after == len(table) or table[after][0] - table[after - 1][0] > 2 * ASSOCIATION:
        return None
    (t0, a), (t1, b) = table[after - 1], table[after]
    share = (time - t0) / (t1 - t0)
    a, b = np.array(a, np.float64), np.array(b, np.float64)
    if a[3:] @ b[3:] < 0:  # q and -q are the same rotation
        b[3:] = -b[3:]
    mixed = (1 - share) * a + share * b
    mixed[3:] /= np.linalg.norm(mixed[3:])  # the mean of neighbours is as good as slerp
    return mixed


def pose(fields):
    """world_from_camera, 4 x 4, of tx ty tz qx qy qz qw."""
    tx, ty, tz, x, y, z, w = map(float, fields)
    matrix = np.eye(4)
    matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    matrix[:3, 3] = tx, ty, tz
    return matrix


def frames(folder):
    """(image, depth [m], world_from_camera) for every image that has both."""
    folder = Path(folder)
    depths, poses = rows(folder / "depth.txt"), rows(folder / "groundtruth.txt")
    found = []
    for time, (name,) in rows(folder / "rgb.txt"):
        depth, where = nearest(depths, time), between(poses, time)
        if depth is not None and where is not None:
            found.append((folder / name, folder / depth[0], pose(where)))
    return found


class Camera:
    """Takes out distortion, so that a pinhole with the same matrix remains."""

    def __init__(self, name, shape=(480, 640)):
        self.pinhole, distortion = CAMERAS[name]
        self.maps = None
        if distortion:
            fx, fy, cx, cy = self.pinhole
            matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
            self.maps = cv2.initUndistortRectifyMap(matrix, np.array(distortion), None, matrix,
                                                    shape[::-1], cv2.CV_32FC1)

    def read_image(self, path):
        image = cv2.imread(str(path))
        return cv2.remap(image, *self.maps, cv2.INTER_LINEAR) if self.maps else image

    def read_depth(self, path):
        depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.float32) / 5000
        return cv2.remap(depth, *self.maps, cv2.INTER_NEAREST) if self.maps else depth


def smooth_surface(depth):
    """Pixels with depth whose neighbours lie on the same surface."""
    filled = np.where(depth > 0, depth, np.inf)
    low = cv2.erode(filled.astype(np.float32), np.ones((5, 5)))
    high = cv2.dilate(np.where(depth > 0, depth, 0).astype(np.float32), np.ones((5, 5)))
    return (depth > 0) & (high - low < JUMP * depth)


def project(points, depth, camera, to_from):
    """Pixels (x, y) with depth -> pixels of the other camera, and the depth there."""
    fx, fy, cx, cy = camera
    x, y = points[:, 0], points[:, 1]
    lifted = np.stack([(x - cx) / fx * depth, (y - cy) / fy * depth, depth], 1)
    moved = lifted @ to_from[:3, :3].T + to_from[:3, 3]
    z = np.maximum(moved[:, 2], 1e-6)
    return np.stack([moved[:, 0] / z * fx + cx, moved[:, 1] / z * fy + cy], 1), z


def weighted_canny(bgr, strength, influence=0.5, sigma=0.7, low_ratio=0.4):
    """threshold of 0..1 -> edges, as network_edges of edvo finds them."""
    gray = cv2.GaussianBlur(cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY), (0, 0), sigma)
    weights = 8 * cv2.dilate(strength, np.ones((3, 3), np.uint8)) ** influence
    gx, gy = (np.rint(cv2.Sobel(gray, cv2.CV_16S, *axis) * weights).astype(np.int16)
              for axis in ((1, 0), (0, 1)))
    highest = 8 * 2040  # of the sum of two Sobel derivatives of 8 bits
    return lambda threshold: cv2.Canny(gx, gy, low_ratio * threshold * highest,
                                       threshold * highest) > 0


def densest(detector, bgr, density):
    """Edges that cover this share of the image, or less where no threshold gives it."""
    wanted = density * bgr.shape[0] * bgr.shape[1]
    if isinstance(detector, detectors.Canny):
        at = lambda threshold: detector.at(bgr, threshold)
    else:
        at = weighted_canny(bgr, detector(bgr))
    low, high = 0.0, 1.0
    for _ in range(12):
        middle = (low + high) / 2
        low, high = (middle, high) if np.count_nonzero(at(middle)) > wanted else (low, middle)
    return at(high)


def found_again(edges, depth, other_edges, other_depth, camera, to_from):
    """How many edge pixels can be judged, and how many are found again."""
    y, x = np.nonzero(edges & smooth_surface(depth))
    points, z = project(np.stack([x, y], 1).astype(np.float64), depth[y, x], camera, to_from)
    column, row = np.rint(points).astype(int).T
    inside = (column >= 1) & (row >= 1) & (column < edges.shape[1] - 1) & (row < edges.shape[0] - 1)
    points, z, column, row = points[inside], z[inside], column[inside], row[inside]
    seen = other_depth[row, column]
    judged = (seen > 0) & (np.abs(seen - z) < HIDDEN * z)
    distance = cv2.distanceTransform((~other_edges).astype(np.uint8), cv2.DIST_L2, 5)
    within = cv2.remap(distance, points[:, 0].astype(np.float32)[:, None],
                       points[:, 1].astype(np.float32)[:, None], cv2.INTER_LINEAR)[:, 0] <= 1
    return int(judged.sum()), int((judged & within).sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", help="a folder in TUM's layout")
    parser.add_argument("detectors", nargs="+", help="canny, FILE.toml, or a teacher's FILE.onnx")
    parser.add_argument("--camera", choices=CAMERAS, default="freiburg1")
    parser.add_argument("--apart", type=int, default=10, help="[frames]")
    parser.add_argument("--pairs", type=int, default=30)
    parser.add_argument("--density", type=float, default=0.04, help="edge pixels / pixels")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    camera = Camera(options.camera)
    every = frames(options.sequence)
    starts = np.linspace(0, len(every) - 1 - options.apart, options.pairs).astype(int)
    named = [(name, detectors.make(name)) for name in options.detectors]
    sums = {name: np.zeros(3) for name, _ in named}
    for start in starts:
        (image, depth, pose_a), (other, other_depth, pose_b) = every[start], every[start + options.apart]
        images = [camera.read_image(p) for p in (image, other)]
        depths = [camera.read_depth(p) for p in (depth, other_depth)]
        for name, detector in named:
            a, b = (densest(detector, i, options.density) for i in images)
            judged, again = found_again(a, depths[0], b, depths[1], camera.pinhole,
                                        np.linalg.inv(pose_b) @ pose_a)
            # What a random mask of the same density would reach, to read the share against.
            chance = cv2.dilate(b.astype(np.uint8), np.ones((3, 3))).mean()
            sums[name] += [judged, again, judged * chance]
    for name, (judged, again, chance) in sums.items():
        print(json.dumps({"detector": name, "found_again": round(again / judged, 4),
                          "by_chance": round(chance / judged, 4), "pixels": int(judged)}))


if __name__ == "__main__":
    main()
