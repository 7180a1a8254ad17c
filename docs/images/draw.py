#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws a run's keyframe points and trajectory as they look from behind and above the first camera.

Needs numpy and opencv-python. docs/images/desk.jpg is (TUM RGB-D fr1/desk, CC BY 4.0):

  edvo run rgbd_dataset_freiburg1_desk -o desk --points desk.ply
  docs/images/draw.py desk.ply desk/trajectory.tum docs/images/desk.jpg
"""
import sys

import cv2
import numpy as np

SIZE = (1100, 620)  # width, height [px]
FOCAL = 760  # [px]
EYE = np.array([-0.75, -2.3, -1.6])  # in the first camera's frame: x right, y down, z forward [m]
LOOK_AT = np.array([-0.85, 0.1, 0.5])
BACKGROUND = (24, 20, 18)
CAMERA_COLOUR = (60, 170, 255)  # BGR


def read_points(path):
    with open(path, "rb") as file:
        data = file.read()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    points = np.frombuffer(data[start:], dtype=[("xyz", "<f4", 3), ("rgb", "u1", 3)])
    return points["xyz"].astype(float), points["rgb"]


def view_from(eye, target):
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross([0, 1, 0], forward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(forward, right), forward])


def project(points, rotation):
    seen = (points - EYE) @ rotation.T
    pixels = FOCAL * seen[:, :2] / seen[:, 2:] + np.array(SIZE) / 2
    return pixels, seen[:, 2]


def main():
    cloud, trajectory, out = sys.argv[1:4]
    xyz, rgb = read_points(cloud)
    rotation = view_from(EYE, LOOK_AT)
    pixels, depth = project(xyz, rotation)
    image = np.full((SIZE[1], SIZE[0], 3), BACKGROUND, np.uint8)
    for i in np.argsort(-depth):  # far ones first
        if depth[i] > 0.2:
            x, y = pixels[i]
            if 0 <= x < SIZE[0] and 0 <= y < SIZE[1]:
                radius = max(1, int(round(3.2 / depth[i])))
                cv2.circle(image, (int(x), int(y)), radius, rgb[i, ::-1].tolist(), -1, cv2.LINE_AA)
    poses = np.loadtxt(trajectory)[:, 1:4]
    way, _ = project(poses, rotation)
    cv2.polylines(image, [np.round(way * 16).astype(np.int32)], False, CAMERA_COLOUR, 2,
                  cv2.LINE_AA, 4)
    cv2.imwrite(out, image, [cv2.IMWRITE_JPEG_QUALITY, 82])


if __name__ == "__main__":
    main()
