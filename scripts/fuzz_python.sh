#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Feeds every reader of the Python package with bytes of its own making, by Atheris.
#
# Usage: scripts/fuzz_python.sh [SECONDS_EACH [NAME...]]     default: 20 s each, all of them
#   FUZZ_SEED   of what is tried; another one each time if not set
#   FUZZ_JOBS   how many at a time; as many as cores if not set
#
# Needs the environment of scripts/test_python.sh. Ends with 1 if one of them has found something; the
# input is then in build/fuzz_python/findings, and tests/fuzz/python/main.py --only NAME FILE tries it
# again. What they learn stays in build/fuzz_python/corpus.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-20}
shift || true
build=build/fuzz_python
python=$PWD/build/venv/bin/python

[[ -x $python ]] && "$python" -c 'import edvo' 2>/dev/null ||
  { echo "fuzz_python: run scripts/test_python.sh first" >&2; exit 1; }
# Not a dependency of anything: only this needs it.
"$python" -c 'import atheris' 2>/dev/null ||
  "$python" -m pip install --quiet --disable-pip-version-check atheris
# Many small files: in memory where there is a folder for that. libFuzzer leaves no time to tidy up.
memory=/dev/shm
[[ -w $memory ]] || memory=${TMPDIR:-/tmp}
TMPDIR=$(mktemp -d -p "$memory" edvo-fuzz-XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
names=("$@")
[[ ${#names[@]} -gt 0 ]] || mapfile -t names < <("$python" tests/fuzz/python/main.py --list)

run_one() {
  local name=$1 log=$build/$1.log status=0 runs
  rm -rf "$build/findings/$name"
  mkdir -p "$build/corpus/$name" "$build/findings/$name"
  "$python" tests/fuzz/python/main.py "$name" "$build/corpus/$name" "$build/findings/$name" -max_total_time="$seconds" \
      -seed="${FUZZ_SEED:-0}" -timeout=20 -rss_limit_mb=3000 -max_len=200000 -len_control=20 \
      -print_final_stats=1 -artifact_prefix="$build/findings/$name/" >"$log" 2>&1 || status=$?
  ! grep -q '^FINDING' "$log" || status=1
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  printf '%-18s %10s executions  %s\n' "$name" "${runs:--}" \
         "$([[ $status -eq 0 ]] && echo 'no finding' || echo "FINDING, see $log")"
  return "$status"
}
export -f run_one
export build seconds python
failed=0
printf '%s\n' "${names[@]}" | xargs -P "${FUZZ_JOBS:-$(nproc)}" -I{} bash -c 'run_one {}' || failed=1
exit "$failed"
