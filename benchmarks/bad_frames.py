#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants bad frames in clips of real sequences and counts the frames that are wrong while tracked.

    benchmarks/bad_frames.py DATA OUT [--edvo build/bin/edvo] [--kind gap]

DATA holds the unpacked TUM sequences rgbd_dataset_freiburg1_xyz, _desk and _rpy; with --icl FOLDER a
recording of ICL-NUIM is taken too. 13 clips of 50 frames are written to OUT at 320 x 240, each plain
and with every kind of fault, then tracked. A frame is wrong if its pose, relative to the first one
of its segment, is more than 10 cm or 5 degrees off the ground truth. Needs numpy and opencv-python
(benchmarks/requirements.txt). The random parts are seeded.
"""
import argparse
import json
import shutil
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

from trials import between, is_wrong, matrix

SIZE = (320, 240)
LENGTH = 50  # frames
FR1 = ("258.653 258.2346 159.07152 127.4069945 "
       "0.262383 -0.953104 -0.005358 0.002628 1.163314")
ICL = "240.6 -240 159.5 119.5"
STARTS = {"xyz": (20, 200, 420, 600), "desk": (10, 150, 300, 450), "rpy": (30, 250, 480),
          "icl": (5, 40)}
OTHER = {"xyz": "desk", "desk": "rpy", "rpy": "xyz", "icl": "xyz"}


def read_list(path):
    lines = [line.split() for line in path.read_text().splitlines() if line and line[0] != "#"]
    return [(words[0], words[1]) for words in lines]


def pairs_of(folder):
    """(stamp, colour file, depth file) of each colour image with a depth image within 20 ms."""
    depth = read_list(folder / "depth.txt")
    stamps = np.array([float(stamp) for stamp, _ in depth])
    pairs = []
    for stamp, colour in read_list(folder / "rgb.txt"):
        nearest = int(np.argmin(abs(stamps - float(stamp))))
        if abs(stamps[nearest] - float(stamp)) < 0.02:
            pairs.append((stamp, folder / colour, folder / depth[nearest][1]))
    return pairs


def load(pair):
    stamp, colour, depth = pair
    image = cv2.resize(cv2.imread(str(colour)), SIZE, interpolation=cv2.INTER_AREA)
    return stamp, image, cv2.imread(str(depth), cv2.IMREAD_UNCHANGED)[::2, ::2].copy()


def write(folder, frames, camera, truth):
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    lists = {"rgb": [], "depth": []}
    for i, (stamp, colour, depth) in enumerate(frames):
        cv2.imwrite(str(folder / f"rgb/{i:03}.jpg"), colour, [cv2.IMWRITE_JPEG_QUALITY, 95])
        cv2.imwrite(str(folder / f"depth/{i:03}.png"), depth)
        lists["rgb"].append(f"{stamp} rgb/{i:03}.jpg\n")
        lists["depth"].append(f"{stamp} depth/{i:03}.png\n")
    for name, lines in lists.items():
        (folder / f"{name}.txt").write_text("".join(lines))
    (folder / "intrinsics.txt").write_text(camera + "\n")
    shutil.copy(truth, folder / "groundtruth.txt")


def joined_truth(own, others, last, joined):
    """Ground truth lines: own up to the stamp `last`, then those of another sequence's frames, at
    the stamps that these have now. All of fr1 was recorded in one frame of reference."""
    lines = [line for line in own.read_text().splitlines()
             if line[:1] != "#" and float(line.split()[0]) <= float(last)]
    poses = np.loadtxt(others)
    for stamp, was in joined:
        nearest = int(np.argmin(abs(poses[:, 0] - float(was))))
        lines.append(" ".join([stamp, *(f"{value:.6f}" for value in poses[nearest, 1:8])]))
    return "\n".join(lines) + "\n"


def replaced(frames, begin, end, change):
    return [change(i, frame) if begin <= i < end else frame for i, frame in enumerate(frames)]


def with_board(frame, i, share, texture):
    """A textured board at 0.8 m that crosses the image from left to right."""
    stamp, colour, depth = frame[0], frame[1].copy(), frame[2].copy()
    left = int(-share * SIZE[0] + i * (1 + share) * SIZE[0] / LENGTH)
    columns = np.arange(max(left, 0), min(left + int(share * SIZE[0]), SIZE[0]))
    colour[:, columns] = texture[:, (columns - left) % SIZE[0]]
    depth[:, columns] = 4000
    return stamp, colour, depth


CARRIED = {share: (slice(120, None), slice(0, 2 * share * SIZE[0] // 100))
           for share in (10, 20, 30, 40)}  # rows and columns of that share of the image [%]


def with_carried(frame, share, texture):
    """Something textured at 0.5 m that moves with the camera, as a robot's arm."""
    stamp, colour, depth = frame[0], frame[1].copy(), frame[2].copy()
    colour[CARRIED[share]], depth[CARRIED[share]] = texture[CARRIED[share]], 2500
    return stamp, colour, depth


def faults(base, foreign, joined, random):
    """Name and frames of each kind; foreign, joined: frames of another sequence."""
    noise = lambda: random.integers(0, 256, (SIZE[1], SIZE[0], 3), dtype=np.uint8)
    texture = cv2.resize(random.integers(0, 256, (60, 80, 3), dtype=np.uint8), SIZE)
    end = len(base)
    last = float(base[24][0])

    def dirty(_, frame):
        colour = frame[1].copy()
        colour[:, :96] = texture[:, :96]
        return frame[0], colour, frame[2]

    yield "plain", base
    yield "gap12", base[:10] + base[22:]
    yield "foreign1", replaced(base, 20, 21, lambda i, f: (f[0],) + foreign[i][1:])
    yield "foreign8", replaced(base, 12, 20, lambda i, f: (f[0],) + foreign[i][1:])
    yield "black8", replaced(base, 10, 18, lambda _, f: (f[0], f[1] * 0, f[2]))
    yield "black20", replaced(base, 10, 30, lambda _, f: (f[0], f[1] * 0, f[2]))
    yield "white12", replaced(base, 10, 22, lambda _, f: (f[0], f[1] * 0 + 255, f[2]))
    yield "noise12", replaced(base, 10, 22, lambda _, f: (f[0], noise(), f[2]))
    yield "joined", base[:25] + [(f"{last + (k + 1) / 30:.6f}", c, d)
                                 for k, (_, c, d) in enumerate(joined)]
    yield "constant_depth", replaced(base, 0, end,
                                     lambda _, f: (f[0], f[1], np.full_like(f[2], 7500)))
    yield "dirty_lens30", replaced(base, 0, end, dirty)
    yield "board40", replaced(base, 0, end, lambda i, f: with_board(f, i, 0.4, texture))
    yield "still_strip33", [with_board((f[0], base[0][1], base[0][2]), i, 1 / 3, texture)
                            for i, f in enumerate(base)]
    for share in CARRIED:
        frames = [with_carried(f, share, texture) for f in base]
        yield f"carried{share}", frames
        yield f"carried{share}_masked", frames


def generate(data, icl, out):
    random = np.random.default_rng(5)
    folders = {name: data / f"rgbd_dataset_freiburg1_{name}" for name in ("xyz", "desk", "rpy")}
    if icl:
        folders["icl"] = icl
    pairs = {name: pairs_of(folder) for name, folder in folders.items()}
    for name, folder in folders.items():
        for start in STARTS[name]:
            base = [load(pair) for pair in pairs[name][start:start + LENGTH]]
            at = int(random.integers(0, 400))
            other = pairs[OTHER[name]]
            foreign = [load(pair) for pair in other[at:at + 21]]
            joined = [load(pair) for pair in other[100:125]]
            for kind, frames in faults(base, foreign, joined, random):
                clip = out / f"{name}{start}.{kind}"
                write(clip, frames, ICL if name == "icl" else FR1, folder / "groundtruth.txt")
                if kind.endswith("_masked"):
                    mask = np.full(SIZE[::-1], 255, np.uint8)
                    mask[CARRIED[int(kind[7:9])]] = 0
                    cv2.imwrite(str(clip / "mask.png"), mask)
                if kind == "joined":
                    stamps = zip([f[0] for f in frames[25:]], [f[0] for f in joined])
                    (clip / "groundtruth.txt").write_text(joined_truth(
                        folder / "groundtruth.txt", folders[OTHER[name]] / "groundtruth.txt",
                        frames[24][0], stamps))


def is_planted(kind, index):
    """Whether the frame shows another sequence, so that no pose of it can be right or wrong."""
    return (kind == "foreign1" and index == 20) or (kind == "foreign8" and 12 <= index < 20)


def evaluate(edvo, folder):
    """Tracked frames, wrong ones among them, lost ones and segments of one clip."""
    kind = folder.name.split(".")[1]
    mask = ["--mask", folder / "mask.png"] if (folder / "mask.png").exists() else []
    with tempfile.TemporaryDirectory() as run:
        subprocess.run([edvo, "run", folder, "--depth-scale", "5000", "-o", run, "--force",
                        "--no-report", "--quiet", *mask], capture_output=True, check=False)
        lines = (Path(run) / "frames.jsonl").read_text().splitlines()
    truth = np.loadtxt(folder / "groundtruth.txt")
    tracked = wrong = lost = 0
    first = {}  # pose and ground truth of each segment's first frame
    for frame in map(json.loads, lines):
        if frame["status"] in ("lost", "skipped"):
            lost += 1
            continue
        other_camera = kind == "joined" and folder.name.startswith("icl")
        if is_planted(kind, frame["index"]) or (other_camera and frame["segment"] > 0):
            continue
        nearest = int(np.argmin(abs(truth[:, 0] - float(frame["stamp"]))))
        true = np.eye(4) if kind.startswith("still") else matrix(truth[nearest, 1:8])
        pose = matrix(frame["pose"])
        begin, true_begin = first.setdefault(frame["segment"], (pose, true))
        if frame["status"] == "restarted":
            continue
        tracked += 1
        wrong += is_wrong(between(np.linalg.inv(true_begin) @ true, np.linalg.inv(begin) @ pose))
    return tracked, wrong, lost, len(first)


def arguments_of(description):
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("data", type=Path, metavar="DATA")
    parser.add_argument("out", type=Path, metavar="OUT")
    parser.add_argument("--edvo", default="build/bin/edvo", metavar="PROGRAM")
    parser.add_argument("--icl", type=Path, metavar="FOLDER")
    parser.add_argument("--verbose", action="store_true", help="print every clip")
    return parser


def print_table(options, is_wanted):
    """Tracks the clips of the wanted kinds and prints what became of each kind."""
    kinds = {}
    for folder in sorted(options.out.iterdir()):
        kind = folder.name.split(".")[1]
        if not is_wanted(kind):
            continue
        counts = evaluate(options.edvo, folder)
        if options.verbose:
            print(folder.name, *counts, flush=True)
        kinds.setdefault(kind, []).append(counts)
    print(f"{'kind':20} {'clips':>6} {'tracked':>8} {'wrong':>6} {'lost':>6}")
    for kind, counts in sorted(kinds.items()):
        tracked, wrong, lost, _ = np.sum(counts, axis=0)
        print(f"{kind:20} {len(counts):6} {tracked:8} {wrong:6} {lost:6}")


def main():
    parser = arguments_of(__doc__.splitlines()[0])
    parser.add_argument("--kind", default="", help="only clips whose kind begins like this")
    options = parser.parse_args()
    if not options.out.exists():
        generate(options.data, options.icl, options.out)
    print_table(options, lambda kind: kind.startswith(options.kind))


if __name__ == "__main__":
    main()
