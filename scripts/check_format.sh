#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fails if a source file is not formatted as clang-format 14 would; --fix formats them instead.
set -euo pipefail
cd "$(dirname "$0")/.."

formatter=$(command -v clang-format-14 || command -v clang-format || true)
if [[ -z $formatter ]]; then
  echo "clang-format is missing: apt-get install clang-format-14" >&2
  exit 1
fi
# Versions disagree on details; only one of them can decide.
if ! "$formatter" --version | grep -q 'version 14\.'; then
  echo "clang-format 14 is needed, found: $("$formatter" --version)" >&2
  exit 1
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
