#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Puts planes that move, or whose pictures do, into clips of real sequences, and counts wrong frames.

    benchmarks/moving_planes.py DATA OUT [--icl FOLDER] [--edvo build/bin/edvo] [--kind tv]

DATA, the 13 clips of 50 frames at 320 x 240, and what is wrong are those of bad_frames.py. Each plane
has a place in space, hides what is behind it, and shows a picture of another sequence: a person who
walks ahead of the camera, people who pass, a screen, a train's window, a belt, a door, something that
approaches, a board that moves from the first frame on, a curtain; `poster` rests: a control. `still_`:
the same before a camera at rest. The clips are kept in OUT and used again. Needs numpy and
opencv-python (benchmarks/requirements.txt). The random parts are seeded.
"""
import re
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

import bad_frames
from bad_frames import FR1, ICL, LENGTH, OTHER, SIZE, STARTS
from trials import matrix

WIDTH, HEIGHT = SIZE
UNITS = 5000  # of depth per metre
DEPTH_NOISE = 0.002  # of a plane, times its depth


@dataclass
class Frame:
    stamp: str
    colour: np.ndarray
    depth: np.ndarray
    pose: np.ndarray  # world from camera


@dataclass
class Clip:
    frames: list
    pictures: list  # colour images of another sequence
    camera: str
    truth: Path
    random: np.random.Generator = None
    rays: np.ndarray = field(init=False)  # x / z, y / z, 1 of each pixel

    def __post_init__(self):
        fx, fy, cx, cy, *distortion = map(float, self.camera.split())
        self.k = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        grid = np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)), -1)
        rays = cv2.undistortPoints(grid.reshape(-1, 1, 2).astype(np.float32), self.k,
                                   np.array(distortion or [0.0] * 5))
        self.rays = np.concatenate([rays.reshape(HEIGHT, WIDTH, 2), np.ones((HEIGHT, WIDTH, 1))], -1)

    def near(self):
        """A distance that hardly anything is nearer than [m]."""
        depths = np.concatenate([f.depth[::8, ::8].ravel() for f in self.frames[::5]])
        return max(0.45, 0.9 * float(np.percentile(depths[depths > 0], 5)) / UNITS)

    def middle(self):
        return self.frames[len(self.frames) // 2].pose

    def size_of(self, share, z):
        """Of a plane that covers this share of the image at z [m]."""
        side = np.sqrt(share) * z
        return side * WIDTH / self.k[0, 0], side * HEIGHT / abs(self.k[1, 1])


def offset(x=0.0, y=0.0, z=1.0, turn=0.0):
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    pose[:3, 3] = x, y, z
    return pose


def with_plane(clip, frame, world_from_plane, size, picture, shift=0, wave=(0, 0), outline=None,
               behind=0.0):
    """The frame with a plane of this size [m], where it is nearer than what is there.

    The picture covers it, moved by shift [px] and bent by wave (amplitude [px], phase). behind: the
    picture is so far behind the plane [m], as in a mirror, while the depth is the plane's.
    """
    camera = np.linalg.inv(world_from_plane) @ frame.pose
    rays = clip.rays @ camera[:3, :3].T
    along = np.where(abs(rays[..., 2]) < 1e-9, 1e-9, rays[..., 2])
    z = -camera[2, 3] / along  # in the camera [m]
    hit = camera[:3, 3] + z[..., None] * rays
    u, v = hit[..., 0] / size[0] + 0.5, hit[..., 1] / size[1] + 0.5
    seen = (z > 0.1) & (u >= 0) & (u < 1) & (v >= 0) & (v < 1)
    seen &= (frame.depth == 0) | (z * UNITS < frame.depth)
    if outline is not None:
        seen &= outline(u, v)
    if behind:
        hit = camera[:3, 3] + (z + behind / abs(along))[..., None] * rays
        u, v = hit[..., 0] / (4 * size[0]) + 0.5, hit[..., 1] / (4 * size[1]) + 0.5
    height, width = picture.shape[:2]
    x = (u * width + shift + wave[0] * np.sin(6 * np.pi * v + wave[1])) % width
    y = (v * height + wave[0] * np.sin(4 * np.pi * u + 1.3 * wave[1])) % height
    shown = cv2.remap(picture, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR,
                      borderMode=cv2.BORDER_WRAP)
    colour, depth = frame.colour.copy(), frame.depth.copy()
    colour[seen] = shown[seen]
    noise = 1 + DEPTH_NOISE * clip.random.standard_normal((HEIGHT, WIDTH))
    depth[seen] = np.clip(z[seen] * UNITS * noise[seen], 0, 65535)
    return replace(frame, colour=colour, depth=depth)


def still(clip):
    """The first frame for ever, with a sensor's noise."""
    noise = clip.random.standard_normal
    first = clip.frames[0]
    return replace(clip, frames=[
        replace(first, stamp=f.stamp,
                colour=np.clip(first.colour + 2.5 * noise((HEIGHT, WIDTH, 3)), 0, 255)
                .astype(np.uint8),
                depth=(first.depth * (1 + DEPTH_NOISE * noise((HEIGHT, WIDTH)))).astype(np.uint16))
        for f in clip.frames])


def resting(clip, share, speed=0, y=0.0, behind=0.0):
    """A plane that rests; its picture slides by speed [px / frame]: a window, a belt."""
    z = clip.near()
    place = clip.middle() @ offset(y=y * z, z=z)
    return [with_plane(clip, f, place, clip.size_of(share, z), clip.pictures[0], speed * i,
                       behind=behind) for i, f in enumerate(clip.frames)]


def screen(clip, share):
    z = clip.near()
    place = clip.middle() @ offset(z=z)
    return [with_plane(clip, f, place, clip.size_of(share, z), picture)
            for f, picture in zip(clip.frames, clip.pictures)]


def curtain(clip, share):
    z = clip.near()
    place = clip.middle() @ offset(x=0.3 * z, z=z)
    return [with_plane(clip, f, place, clip.size_of(share, z), clip.pictures[0], wave=(8, i / 5))
            for i, f in enumerate(clip.frames)]


def person(u, v):
    body = ((u - 0.5) / 0.5) ** 2 + ((v - 0.6) / 0.45) ** 2 < 1
    return body | (((u - 0.5) / 0.22) ** 2 + ((v - 0.15) / 0.16) ** 2 < 1)


def following(clip, share, sway=0.04):
    """Somebody walks ahead of the camera, sways [m] and bends."""
    z = clip.near()
    size = clip.size_of(1.35 * share, z)
    return [with_plane(clip, f, f.pose @ offset(
        x=sway * np.sin(i / 5), y=0.3 * sway * abs(np.sin(i / 2.5)),
        z=z * (0.95 - 0.05 * np.sin(i / 9))), size, clip.pictures[0], wave=(4, i / 3), outline=person)
            for i, f in enumerate(clip.frames)]


def passers(clip, count):
    z, frames = clip.near(), clip.frames
    size = clip.size_of(0.3, z)
    for k in range(count):
        way = z if k % 2 else -z
        frames = [with_plane(clip, f, clip.middle() @ offset(
            x=way * (0.9 - 0.045 * ((i + 13 * k) % LENGTH)), z=z * (1 - 0.1 * k)), size,
            clip.pictures[7 * k], wave=(4, i / 3), outline=person) for i, f in enumerate(frames)]
    return frames


def door(clip, share):
    z = clip.near()
    size = clip.size_of(share, z)
    hinge = clip.middle() @ offset(x=-0.5 * size[0], z=z)
    turns = [-1.3 * min(max((i - 8) / 34, 0), 1) for i in range(len(clip.frames))]
    return [with_plane(clip, f, hinge @ offset(z=0, turn=turn) @ offset(x=0.5 * size[0], z=0), size,
                       clip.pictures[0]) for f, turn in zip(clip.frames, turns)]


def board_first(clip, share):
    """A board that moves from the first frame on."""
    z = clip.near()
    return [with_plane(clip, f, clip.frames[0].pose @ offset(x=0.012 * i, z=z),
                       clip.size_of(share, z), clip.pictures[0]) for i, f in enumerate(clip.frames)]


def approaching(clip, share):
    z = clip.near()
    return [with_plane(clip, f, clip.middle() @ offset(z=z * (1 - 0.008 * i)),
                       clip.size_of(share, z), clip.pictures[0]) for i, f in enumerate(clip.frames)]


MOVING = {
    "poster30": partial(resting, share=0.3),
    "screen30": partial(screen, share=0.3),
    "window30": partial(resting, share=0.3, speed=5),
    "belt50": partial(resting, share=0.5, speed=3, y=0.25),
    "mirror30": partial(resting, share=0.3, behind=1.5),
    "following30": partial(following, share=0.3),
    "following45_rigid": partial(following, share=0.45, sway=0.0),
    "passers2": partial(passers, count=2),
    "door30": partial(door, share=0.3),
    "approaching30": partial(approaching, share=0.3),
    "board_first50": partial(board_first, share=0.5),
    "curtain50": partial(curtain, share=0.5),
}
STILL = ("screen30", "window30", "following30", "passers2", "door30", "approaching30")
KINDS = {**MOVING, **{f"still_{name}": lambda clip, name=name: MOVING[name](still(clip))
                      for name in STILL}}


def clips(data, icl):
    folders = {name: data / f"rgbd_dataset_freiburg1_{name}" for name in ("xyz", "desk", "rpy")}
    if icl:
        folders["icl"] = icl
    pairs = {name: bad_frames.pairs_of(folder) for name, folder in folders.items()}
    for name, folder in folders.items():
        truth = np.loadtxt(folder / "groundtruth.txt")
        others = pairs[OTHER[name]][100:100 + LENGTH]
        pictures = [bad_frames.load(other)[1] for other in others]
        for start in STARTS[name]:
            frames = []
            for pair in pairs[name][start:start + LENGTH]:
                stamp, colour, depth = bad_frames.load(pair)
                nearest = int(np.argmin(abs(truth[:, 0] - float(stamp))))
                frames.append(Frame(stamp, colour, depth, matrix(truth[nearest, 1:8])))
            pictures += pictures[-1:] * (len(frames) - len(pictures))
            yield f"{name}{start}", Clip(frames, pictures, ICL if name == "icl" else FR1,
                                         folder / "groundtruth.txt")


def generate(data, icl, out):
    for name, clip in clips(data, icl):
        for kind, plant in KINDS.items():
            clip.random = np.random.default_rng([5, sum(map(ord, kind))])
            frames = plant(clip)
            folder = out / f"{name}.{kind}"
            bad_frames.write(folder, [(f.stamp, f.colour, f.depth) for f in frames], clip.camera,
                             clip.truth)


def main():
    parser = bad_frames.arguments_of(__doc__.splitlines()[0])
    parser.add_argument("--kind", default=".*", help="only kinds that match this expression")
    options = parser.parse_args()
    if not options.out.exists():
        generate(options.data, options.icl, options.out)
    bad_frames.print_table(options, lambda kind: re.fullmatch(options.kind, kind))


if __name__ == "__main__":
    main()
