# SPDX-License-Identifier: MIT
"""ODS / OIS / AP of detectors on UDED, on BIPEDv2's test images or on its held-out training images.

python3 training/evaluate.py --data FOLDER --set uded models/edvo_edges.toml canny teacher.onnx
"""
import argparse
import json

import cv2
import numpy as np

import benchmark
import data
import detectors


def images_of(folder, name, half):
    """(image, truth) one after another. Half: the scale at which odometry sees the world."""
    found = data.uded_pairs(folder) if name == "uded" else data.pairs(folder, name)
    for image, label in found:
        bgr, drawn = data.read(image), data.read(label, cv2.IMREAD_GRAYSCALE)
        if half:
            bgr = data.shrink(bgr, 0.5)
            drawn = benchmark.thin(data.shrink(drawn, 0.5) > 0)
        yield bgr, drawn > 0


def masks_of(detector, bgr, thresholds, thin):
    """One edge mask for each threshold."""
    if isinstance(detector, detectors.Canny):
        return [detector.at(bgr, t) for t in thresholds]
    crests = benchmark.suppress(detector(bgr))
    return [benchmark.thin(crests >= t) if thin else crests >= t for t in thresholds]


def score(detector, images, thresholds, thin=False):
    counts = [benchmark.counts_of(masks_of(detector, bgr, thresholds, thin), truth)
              for bgr, truth in images]
    return benchmark.summary(counts, thresholds)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", required=True)
    parser.add_argument("--set", choices=["uded", "test", "held_out"], default="uded")
    parser.add_argument("--half", action="store_true", help="at half resolution (BIPEDv2)")
    parser.add_argument("--thin", action="store_true", help="thin the crests once more")
    parser.add_argument("--thresholds", type=int, default=33, help="99 is the standard")
    parser.add_argument("--images", type=int, help="only the first so many")
    parser.add_argument("detectors", nargs="+", help="canny, FILE.toml, or a teacher's FILE.onnx")
    options = parser.parse_args()
    # Denser where a network that was trained on thin labels has most of its answers.
    thresholds = (np.arange(1, options.thresholds + 1) / (options.thresholds + 1)) ** 2
    images = list(images_of(options.data, options.set, options.half))[:options.images]
    for name in options.detectors:
        result = score(detectors.make(name), images, thresholds, options.thin)
        print(json.dumps({"detector": name} | {k: round(v, 4) for k, v in result.items()}),
              flush=True)


if __name__ == "__main__":
    main()
