# SPDX-License-Identifier: MIT
"""Trains EdgeNet. See README.md; `--resume` goes on from the last checkpoint in --out."""
import argparse
import copy
import math
import queue
import threading
import time
from pathlib import Path

import torch
from torch.nn import functional

import data
import model


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--data", help="folder that holds Data, BSDS and UDED")
    source.add_argument("--free", help="folder of images that teachers alone label (fetch_free.py)")
    parser.add_argument("--out", required=True, help="folder for checkpoints, the log and the cache")
    parser.add_argument("--teacher", nargs="+",
                        help="ONNX file (BGR 0..255 -> probabilities) or FILE.toml, with @ZOOM to be "
                             "shown images enlarged; of several, the mean of their logits")
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--batch", type=int, default=8)
    parser.add_argument("--size", type=int, default=192, help="side of a crop [pixels]")
    parser.add_argument("--rate", type=float, default=3e-3, help="highest learning rate")
    parser.add_argument("--warmup", type=int, default=300, help="steps until the highest rate")
    parser.add_argument("--positive-weight", type=float, default=4.0)
    parser.add_argument("--unlabelled-share", type=float, default=0.3)
    parser.add_argument("--average", type=float, default=0.998, help="decay of the mean weights")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--save-every", type=int, default=250)
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--start-from", help="checkpoint whose mean weights begin a new run")
    parser.add_argument("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    options = parser.parse_args()
    if options.free and not options.teacher:
        parser.error("--free needs --teacher")
    return options


def rate_at(step, options):
    """Linear warm-up, then half a cosine down to nothing."""
    if step < options.warmup:
        return options.rate * (step + 1) / options.warmup
    done = (step - options.warmup) / max(1, options.steps - options.warmup)
    return options.rate * 0.5 * (1 + math.cos(math.pi * min(done, 1)))


def loss_of(logits, label, teacher, labelled, positive_weight):
    """First head: the label, edge pixels weighted up. Second head: the teacher's probability."""
    weight = 1 + (positive_weight - 1) * label
    drawn = functional.binary_cross_entropy_with_logits(logits[:, :1], label, weight,
                                                        reduction="none").mean((1, 2, 3))
    drawn = (drawn * labelled).sum() / labelled.sum().clamp(min=1)
    said = functional.binary_cross_entropy_with_logits(logits[:, 1:], teacher)
    return drawn + said, drawn.item(), said.item()


def blend(mean, net, decay):
    with torch.no_grad():
        for kept, new in zip(mean.state_dict().values(), net.state_dict().values()):
            if kept.dtype.is_floating_point:
                kept.lerp_(new, 1 - decay)
            else:
                kept.copy_(new)


def prefetch(make, first, last):
    """Batches made in a thread of their own, in order."""
    ready = queue.Queue(4)
    threading.Thread(target=lambda: [ready.put(make(s)) for s in range(first, last)],
                     daemon=True).start()
    return (ready.get() for _ in range(first, last))


def main():
    options = arguments()
    torch.manual_seed(options.seed)
    torch.set_num_threads(options.threads)
    out = Path(options.out)
    samples = data.load(options.data, out / "teacher", options.teacher, options.free)
    data.cv2.setNumThreads(1)
    print(f"{len(samples)} samples", flush=True)

    layout = torch.channels_last  # a fifth faster on a CPU
    net = model.EdgeNet().to(options.device, memory_format=layout)
    if options.start_from:
        net.load_state_dict(torch.load(options.start_from, map_location=options.device)["mean"])
    mean = copy.deepcopy(net)
    optimizer = torch.optim.AdamW(net.parameters(), options.rate, weight_decay=1e-4)
    first = 0
    checkpoint = out / "checkpoint.pth"
    if options.resume and checkpoint.exists():
        saved = torch.load(checkpoint, map_location=options.device)
        net.load_state_dict(saved["net"])
        mean.load_state_dict(saved["mean"])
        optimizer.load_state_dict(saved["optimizer"])
        first = saved["step"]
    log = open(out / "log.csv", "a")
    make = lambda step: data.batch(samples, options.batch, options.size, options.unlabelled_share,
                                   options.seed, step)
    started = time.time()
    sums = [0.0, 0.0]
    for step, (bgr, label, teacher, labelled) in enumerate(
            prefetch(make, first, options.steps), first):
        for group in optimizer.param_groups:
            group["lr"] = rate_at(step, options)
        logits = net(model.to_input(bgr).to(options.device, memory_format=layout))
        loss, drawn, said = loss_of(logits, label.to(options.device), teacher.to(options.device),
                                    labelled.to(options.device), options.positive_weight)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        blend(mean, net, min(options.average, (step + 1) / (step + 10)))
        sums = [sums[0] + drawn, sums[1] + said]
        if (step + 1) % options.save_every == 0 or step + 1 == options.steps:
            count = (step % options.save_every) + 1
            line = f"{step + 1},{sums[0] / count:.5f},{sums[1] / count:.5f},{time.time() - started:.0f}"
            print(line, file=log, flush=True)
            sums = [0.0, 0.0]
            saved = {"step": step + 1, "net": net.state_dict(), "mean": mean.state_dict(),
                     "optimizer": optimizer.state_dict(), "options": vars(options)}
            torch.save(saved, checkpoint.with_suffix(".part"))
            checkpoint.with_suffix(".part").replace(checkpoint)


if __name__ == "__main__":
    main()
