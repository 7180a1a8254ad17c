#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fails if a source file is not formatted as clang-format 14 would; --fix formats them instead.
set -euo pipefail
cd "$(dirname "$0")/.."

# Versions disagree on details; only one of them can decide.
formatter=$(command -v clang-format-14 || true)
if [[ -z $formatter ]]; then
  echo "clang-format-14 is missing (Debian 12 has it)" >&2
  exit 77  # ctest: skipped
fi

mapfile -t files < <(find src apps tests examples benchmarks python \
  \( -name '*.hpp' -o -name '*.cpp' \) 2>/dev/null | sort)
if [[ ${1:-} == --fix ]]; then
  exec "$formatter" -i "${files[@]}"
fi
"$formatter" --dry-run --Werror "${files[@]}" || {
  echo "format: run scripts/check_format.sh --fix" >&2
  exit 1
}
echo "format: ${#files[@]} files, all formatted"
