#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs DexiNed at its full size (35.2 M parameters, random weights) through edvo and through torch,
# and compares: no pixel may differ by more than 1e-4. Once with its weights as floats and once as the
# OpenCV zoo stores them. Not part of the tests: it needs python3-torch and python3-onnx and takes a
# minute.
#
#   scripts/check_dexined.sh [IMAGE]     default: a pattern of 640 x 480 px
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=${PYTHON:-/usr/bin/python3}  # Debian's: it sees Debian's torch
program=${EDVO:-build/bin/edvo}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

image=${1:-$folder/pattern.png}
[[ $# -gt 0 ]] || "$python" - "$image" <<'PYTHON'
import sys
sys.path.insert(0, "scripts")
import cv2
import dexined_random
cv2.imwrite(sys.argv[1], dexined_random.example_image(480, 640))
PYTHON

"$python" scripts/dexined_random.py "$folder" --image "$image"
for network in dexined dexined_int8; do
  "$program" edges "$image" -o "$folder/$network.npy" --raw --model "$folder/$network.toml" >/dev/null
done
"$python" - "$folder" <<'PYTHON'
import sys
import numpy as np
reference, *answers = (np.load(f"{sys.argv[1]}/{name}.npy")
                       for name in ("reference", "dexined", "dexined_int8"))
for name, answer in zip(("floats", "8-bit blocks"), answers):
    difference = float(np.abs(answer - reference).max())
    print(f"{name}: largest difference to torch {difference:.2g}")
    if not difference <= 1e-4:
        sys.exit(f"{name}: more than 1e-4")
PYTHON
