#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds with clang 14, warnings as errors, and address and undefined behaviour sanitizers (or those
# named), runs the tests of the library and the program, and compares: the program that gcc built
# (scripts/test.sh, in build/) and this one must give the same bits.
#
# Usage: scripts/check_clang.sh [SANITIZERS [CTEST_ARGUMENT...]]
#        scripts/check_clang.sh thread    # races
#        SKIP='^(Surface|MapCommand)[.]' scripts/check_clang.sh    # without these tests
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

sanitizers=${1:-address,undefined}
shift || true
folder=build-${sanitizers//,/-}
install_packages scripts/packages_checks.txt
forget_other_place "$folder"
cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE= -DCMAKE_CXX_FLAGS="-O2 -g1" \
      -DCMAKE_CXX_COMPILER=clang++-14 -DEDVO_WARNINGS_AS_ERRORS=ON -DEDVO_SANITIZE="$sanitizers"
ninja -C "$folder" -j "$(parallel_jobs)" edvo_tests edvo_ros2_tests edvo_app
export ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=suppressions=$PWD/scripts/tsan_suppressions.txt
ctest --test-dir "$folder" --parallel "$(parallel_jobs)" --output-on-failure --no-tests=error \
      --exclude-regex "^(install|example|shared|format|layers|sizes|links|edvo_)${SKIP:+|$SKIP}" "$@"

[[ -x build/bin/edvo ]] || { configure; build edvo_app; }
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
build/bin/edvo synth "$scratch/room" --frames 60 --size 320x240 --seed 5
for method in canny+corner cnn+corner origin; do
  for compiled in build "$folder"; do
    "$compiled/bin/edvo" run "$scratch/room" --method "$method" -o "$scratch/$compiled-$method" \
                         --no-report >/dev/null
  done
  cmp "$scratch/build-$method/trajectory.tum" "$scratch/$folder-$method/trajectory.tum"
  echo "$method: the same bits with $(c++ --version | head -1) and $(clang++-14 --version | head -1)"
done
