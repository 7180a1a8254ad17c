#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds with clang 14, warnings as errors, runs the tests, and compares: the program that gcc built
# (scripts/test.sh, in build/) and this one must give the same bits.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages scripts/packages_checks.txt
cmake -S . -B build-clang -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++-14 \
      -DEDVO_WARNINGS_AS_ERRORS=ON
ninja -C build-clang -j "$(parallel_jobs)"
ctest --test-dir build-clang --parallel "$(parallel_jobs)" --output-on-failure --no-tests=error

[[ -x build/bin/edvo ]] || { configure; build edvo_app; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
build/bin/edvo synth "$folder/room" --frames 60 --sensor kinect1 --seed 5
for method in canny+corner cnn+corner origin; do
  for compiler in build build-clang; do
    "$compiler/bin/edvo" run "$folder/room" --method "$method" -o "$folder/$compiler-$method" --quiet
  done
  cmp "$folder/build-$method/trajectory.tum" "$folder/build-clang-$method/trajectory.tum"
  echo "$method: the same bits with $(c++ --version | head -1) and $(clang++-14 --version | head -1)"
done
