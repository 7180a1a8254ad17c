# SPDX-License-Identifier: MIT
"""A sequence of any length from a short one: its images forth and back, again and again.

python3 benchmarks/loop.py SEQUENCE OUT 30000 && edvo run OUT

SEQUENCE: a TUM-layout folder of `edvo synth` (or any whose lists give one depth image per colour
image). OUT holds lists and links only; its calibration is copied.
"""
import argparse
import pathlib
import shutil
import sys


def entries(file):
    return [line.split()[1] for line in file.read_text().splitlines()
            if line and not line.startswith("#")]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sequence", type=pathlib.Path, help="of edvo synth, or any with lists")
    parser.add_argument("out", type=pathlib.Path, help="folder of lists and links, made here")
    parser.add_argument("frames", type=int, help="how many")
    arguments = parser.parse_args()
    source, out, count = arguments.sequence.resolve(), arguments.out, arguments.frames
    colour, depth = entries(source / "rgb.txt"), entries(source / "depth.txt")
    if len(colour) != len(depth):
        sys.exit(f"{source}: {len(colour)} colour and {len(depth)} depth images; need as many")
    out.mkdir(parents=True)
    for folder in ("rgb", "depth"):
        (out / folder).symlink_to(source / folder)
    if (source / "camera.toml").exists():
        shutil.copy(source / "camera.toml", out)
    there = list(range(len(colour)))
    round_trip = there + there[-2:0:-1]
    for name, images in (("rgb.txt", colour), ("depth.txt", depth)):
        (out / name).write_text("".join(
            f"{1000 + i / 30:.6f} {images[round_trip[i % len(round_trip)]]}\n" for i in range(count)))


if __name__ == "__main__":
    main()
