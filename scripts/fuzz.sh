#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Feeds every reader of bytes from outside with bytes of its own making, by libFuzzer with the
# address and undefined behaviour sanitizers.
#
# Usage: scripts/fuzz.sh [SECONDS_EACH [NAME...]]     default: 20 s each, all of them
#   FUZZ_SEED   of what is tried; another one each time if not set
#   FUZZ_CXX    the compiler, clang++-14 if not set
#
# Ends with 1 if one of them has found something; the input is then in build/fuzz/findings. What
# they learn stays in build/fuzz/corpus; tests/fuzz/corpus has a small start of each.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh
seconds=${1:-20}
shift || true
build=build/fuzz

compiler=${FUZZ_CXX:-clang++-14}
command -v "$compiler" >/dev/null || install_packages scripts/packages_checks.txt
forget_other_place "$build"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_COMPILER="$compiler" \
      -DEDVO_BUILD_FUZZERS=ON -DEDVO_BUILD_APPS=OFF -DEDVO_BUILD_TESTS=OFF >"$build.log" 2>&1 ||
  { cat "$build.log" >&2; exit 1; }
names=("$@")
if [[ ${#names[@]} -eq 0 ]]; then
  for file in tests/fuzz/*_fuzz.cpp; do names+=("$(basename "$file" _fuzz.cpp)"); done
fi
ninja -C "$build" "${names[@]/%/_fuzz}" >"$build.log" 2>&1 || { cat "$build.log" >&2; exit 1; }

# A stack as large as the program's; no leak is found by a reader that ends, only by one that runs
# out: -rss_limit_mb. What a file says it needs must not be asked of the system at once.
export ASAN_OPTIONS=detect_stack_use_after_return=0:allocator_may_return_null=0
export UBSAN_OPTIONS=print_stacktrace=1
run_one() {
  local name=$1 log=$build/$1.log
  mkdir -p "$build/corpus/$name" "$build/findings/$name" "tests/fuzz/corpus/$name"
  local status=0
  "$build/bin/${name}_fuzz" -max_total_time="$seconds" -seed="${FUZZ_SEED:-0}" -timeout=10 -rss_limit_mb=3000 \
      -malloc_limit_mb=2000 -max_len=65536 -print_final_stats=1 -artifact_prefix="$build/findings/$name/" \
      "$build/corpus/$name" "tests/fuzz/corpus/$name" >"$log" 2>&1 || status=$?
  local runs
  runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  printf '%-18s %10s executions  %s\n' "$name" "${runs:--}" \
         "$([[ $status -eq 0 ]] && echo 'no finding' || echo "FINDING, see $log")"
  return "$status"
}
export -f run_one
export build seconds
failed=0
printf '%s\n' "${names[@]}" | xargs -P "$(nproc)" -I{} bash -c 'run_one {}' || failed=1
exit "$failed"
