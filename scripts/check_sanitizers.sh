#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds with address and undefined behaviour sanitizers (or those named: scripts/check_sanitizers.sh
# thread) and runs the tests of the library and the program.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

sanitizers=${1:-address,undefined}
folder=build-${sanitizers//,/-}
install_packages
cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE= -DCMAKE_CXX_FLAGS="-O1 -g1" \
      -DEDVO_SANITIZE="$sanitizers"
ninja -C "$folder" -j "$(parallel_jobs)" edvo_tests edvo_app
export ASAN_OPTIONS=detect_leaks=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1
ctest --test-dir "$folder" --parallel "$(parallel_jobs)" --output-on-failure --no-tests=error \
      --exclude-regex '^(install|example|shared|format|layers)'
