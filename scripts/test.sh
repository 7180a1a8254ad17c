#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Sets up what is missing, builds everything and runs all tests: the library and the program, layer
# and format checks, and the examples against an installed edvo. Arguments go to cmake.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages
# What the Python tests need is downloaded while everything compiles.
prepared=$(mktemp)
scripts/test_python.sh --prepare >"$prepared" 2>&1 &
preparing=$!
configure "$@"
build
ctest --test-dir build --parallel "$(parallel_jobs)" --output-on-failure --no-tests=error
wait "$preparing" || cat "$prepared" >&2  # tried again below
rm -f "$prepared"
exec scripts/test_python.sh
