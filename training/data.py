# SPDX-License-Identifier: MIT
"""Images, labels and the teacher's answers: read once, kept in memory at a few scales, cut into crops.

Below DATA: Data/BIPEDv2/BIPED/edges/{imgs,edge_maps}/{train,test}/rgbr, BSDS/BSDS500/data/images,
UDED/{imgs,gt} (README.md says where each comes from). UDED is for tests alone: nothing here trains
on it, and images of BSDS500 that it contains are left out. A folder of free images can take the
place of all of them.
"""
import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import torch

import detectors

BIPED = "Data/BIPEDv2/BIPED/edges"
BSDS = "BSDS/BSDS500/data/images"
SCALES = (1.0, 0.7, 0.5)  # of BIPEDv2 (1280 x 720); BSDS500 is used as it is
FREE_SIDES = (800, 500)  # longest sides of a free image [pixels]
HELD_OUT = 19  # the last of BIPEDv2's training images: never trained on, they choose between runs


@dataclass
class Sample:
    bgr: np.ndarray  # H x W x 3 [0..255]
    label: np.ndarray  # H x W [0..255], 255 where an annotator drew; all 0 if there is no label
    teacher: np.ndarray  # H x W [0..255], the teacher's probability
    labelled: bool


def read(path, flags=cv2.IMREAD_COLOR):
    image = cv2.imread(str(path), flags)
    if image is None:
        raise SystemExit(f"{path}: not an image that can be read")
    return image


def is_whole(jpeg):
    """Decoders fill the rest of a truncated file with grey; the stored copy of BIPEDv2 has one."""
    return jpeg.read_bytes()[-2:] == b"\xff\xd9"


def pairs(data, part):
    """(image, label) of BIPEDv2: part is train, held_out or test."""
    folder = "test/rgbr" if part == "test" else "train/rgbr/real"
    images = sorted((Path(data) / BIPED / "imgs" / folder).glob("*.jpg"))
    if not images:
        raise SystemExit(f"{data}/{BIPED}/imgs/{folder}: no images")
    found = [(i, Path(data) / BIPED / "edge_maps" / folder / f"{i.stem}.png") for i in images
             if is_whole(i)]
    return {"test": found, "train": found[:-HELD_OUT], "held_out": found[-HELD_OUT:]}[part]


def uded_pairs(data):
    folder = Path(data) / "UDED"
    return [(folder / i, folder / g) for i, g in json.loads((folder / "test_pair.lst").read_text())]


def unlabelled(data):
    """BSDS500's images, without those that UDED took."""
    tested = {p.stem for p, _ in uded_pairs(data)} if (Path(data) / "UDED").exists() else set()
    numbers = {part for stem in tested for part in stem.replace("_", "-").split("-")}
    return [p for p in sorted((Path(data) / BSDS).glob("*/*.jpg")) if p.stem not in numbers]


def images_below(folder):
    """The files that fetch_free.py writes."""
    found = sorted(p for p in Path(folder).iterdir() if p.suffix in (".jpg", ".jpeg", ".png"))
    if not found:
        raise SystemExit(f"{folder}: no images")
    return found


def shrink(image, scale):
    if scale == 1:
        return image
    return cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def shrink_label(label, scale):
    """A line one pixel wide stays one: area averages it, the factor gives back its strength."""
    return np.minimum(shrink(label, scale).astype(np.float32) / scale, 255).astype(np.uint8)


def load(data, cache, teachers=None, free=None):
    """All training samples; the teachers' answers are computed once and kept in `cache` as PNG.

    With a folder of free images, these alone are read, and nothing has a label.
    """
    cache = Path(cache)
    cache.mkdir(parents=True, exist_ok=True)
    net = make_teacher(teachers) if teachers else None
    if free:
        jobs = [(i, None, s) for i in images_below(free) for s in FREE_SIDES]
    else:
        jobs = [(i, g, s) for i, g in pairs(data, "train") for s in SCALES]
        jobs += [(i, None, 1.0) for i in unlabelled(data)] if net else []
    samples = []
    for image, label, scale in jobs:
        bgr = read(image)
        bgr = shrink(bgr, min(1, scale / max(bgr.shape)) if free else scale)
        if label is None:
            drawn = np.zeros(bgr.shape[:2], np.uint8)
        else:
            drawn = shrink_label(read(label, cv2.IMREAD_GRAYSCALE), scale)
        kept = cache / f"{image.parent.name}_{image.stem}_{scale}.png"
        if net is None:
            said = drawn
        elif kept.exists():
            said = read(kept, cv2.IMREAD_GRAYSCALE)
        else:
            said = np.rint(net(bgr) * 255).astype(np.uint8)
            cv2.imwrite(str(kept), said)
        samples.append(Sample(bgr, drawn, said, label is not None))
    return samples


def make_teacher(names):
    return detectors.make(names[0]) if len(names) == 1 else detectors.Together(names)


def crop(sample, size, rng):
    """A square cut at a random place, angle, size and mirror image: bgr, label, teacher."""
    height, width = sample.bgr.shape[:2]
    zoom = rng.uniform(0.8, 1.25)
    quarter_turns = rng.integers(4)
    angle = 90 * quarter_turns + rng.normal() * 5
    reach = size / 2 / zoom
    x = rng.uniform(min(reach, width / 2), max(width - reach, width / 2))
    y = rng.uniform(min(reach, height / 2), max(height - reach, height / 2))
    matrix = cv2.getRotationMatrix2D((x, y), angle, zoom)
    matrix[:, 2] += np.array([size / 2 - x, size / 2 - y])
    if rng.random() < 0.5:
        matrix[0] = [-matrix[0, 0], -matrix[0, 1], size - 1 - matrix[0, 2]]
    warp = lambda image: cv2.warpAffine(image, matrix, (size, size), flags=cv2.INTER_LINEAR,
                                        borderMode=cv2.BORDER_REFLECT_101)
    return warp(sample.bgr), warp(sample.label), warp(sample.teacher)


def disturb(bgr, rng):
    """What cameras do: exposure, gamma, white balance, grey, blur, noise, compression."""
    x = bgr.astype(np.float32) / 255
    if rng.random() < 0.7:
        x = np.power(x, rng.uniform(0.6, 1.6)) * rng.uniform(0.6, 1.15)
    if rng.random() < 0.5:
        x = x * rng.uniform(0.85, 1.15, 3).astype(np.float32)
    if rng.random() < 0.15:
        x = np.repeat(cv2.cvtColor(np.clip(x, 0, 1), cv2.COLOR_BGR2GRAY)[..., None], 3, 2)
    if rng.random() < 0.2:
        x = cv2.GaussianBlur(x, (0, 0), rng.uniform(0.4, 1.0))
    if rng.random() < 0.4:
        x = x + rng.standard_normal(x.shape, np.float32) * rng.uniform(0.005, 0.04)
    x = np.clip(x * 255, 0, 255).astype(np.uint8)
    if rng.random() < 0.2:
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(40, 90))]
        x = cv2.imdecode(cv2.imencode(".jpg", x, quality)[1], cv2.IMREAD_COLOR)
    return x


def batch(samples, count, size, unlabelled_share, seed, step):
    """The batch of a step: the same for the same seed and step, so that training can be resumed."""
    rng = np.random.default_rng([seed, step])
    with_label = [s for s in samples if s.labelled]
    without = [s for s in samples if not s.labelled]
    images, labels, teachers, labelled = [], [], [], []
    for _ in range(count):
        free = not with_label or (without and rng.random() < unlabelled_share)
        source = without if free else with_label
        sample = source[rng.integers(len(source))]
        bgr, label, teacher = crop(sample, size, rng)
        images.append(disturb(bgr, rng))
        labels.append(label)
        teachers.append(teacher)
        labelled.append(sample.labelled)
    probability = lambda maps: torch.from_numpy(np.stack(maps)[:, None].astype(np.float32) / 255)
    return np.stack(images), probability(labels), probability(teachers), torch.tensor(labelled)
