#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# clang-tidy on the source files of the library and the program that differ from a commit:
# scripts/check_tidy.sh [COMMIT], without it those of the last one. All: scripts/check_tidy.sh --all
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages scripts/packages_checks.txt
if [[ ${1:-} == --all ]]; then
  set -- 4b825dc642cb6eb9a060e54bf8d69288fbee4904  # git's empty tree
else
  git rev-parse --quiet --verify "${1:-HEAD~1}^{commit}" >/dev/null || exit 0  # nothing before
fi
[[ -e build/compile_commands.json ]] || configure
mapfile -t changed < <(git diff --name-only --diff-filter=d "${1:-HEAD~1}" -- \
                         'src/*.cpp' 'apps/*.cpp')
[[ ${#changed[@]} -gt 0 ]] || exit 0
printf '%s\n' "${changed[@]}" |
  xargs -P "$(parallel_jobs)" -n 1 clang-tidy-14 -quiet -p build --warnings-as-errors='*'
