#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# clang-tidy on the source files that differ from a commit: scripts/check_tidy.sh [COMMIT], without
# it those of the last one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages scripts/packages_checks.txt
git rev-parse --quiet --verify "${1:-HEAD~1}^{commit}" >/dev/null || exit 0  # nothing before
[[ -e build/compile_commands.json ]] || configure
mapfile -t changed < <(git diff --name-only --diff-filter=d "${1:-HEAD~1}" -- \
                         'src/*.cpp' 'apps/*.cpp' 'tests/*_test.cpp')
[[ ${#changed[@]} -gt 0 ]] || exit 0
printf '%s\n' "${changed[@]}" |
  xargs -P "$(parallel_jobs)" -n 1 clang-tidy-14 -quiet -p build --warnings-as-errors='*'
