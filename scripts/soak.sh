#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs edvo under faults: killed, stopped, on full and slow disks, without memory, handles or a
# home. After each try what is on disk must be whole (scripts/check_run_folder.py), and the status
# must be one of docs/errors.md that says what happened: never a crash, never "a bug".
#
# Usage: scripts/soak.sh [TRIES [ATTACK...]]     default: 100 tries where they are random
#   attacks: killed stopped full failing readonly handles memory locale paths twice removed
#            stalled short clock
#
# Needs build/bin/edvo (scripts/demo.sh builds it). Prints one line per attack; ends with 1 if any
# try was not as it must be.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tries=${1:-100}
shift || true
attacks=("$@")
[[ ${#attacks[@]} -gt 0 ]] ||
  attacks=(killed stopped full failing readonly handles memory locale paths twice removed stalled
           short clock)
edvo=$PWD/build/bin/edvo
check=$PWD/scripts/check_run_folder.py
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for shim in failing_write slow_system; do
  "${CC:-cc}" -shared -fPIC -O1 -o "$work/$shim.so" "tests/faults/$shim.c" -ldl ||
    { echo "edvo: tests/faults/$shim.c cannot be compiled" >&2; exit 1; }
done
"$edvo" synth "$work/room" --size 160x120 --frames 60 --threads 2 2>/dev/null >/dev/null ||
  { echo "edvo: no sequence to run on" >&2; exit 1; }

failed=0 count=0 bad=0
# judge FOLDER STATUS ALLOWED...: counts a try, and says what is wrong with it.
judge() {
  local folder=$1 status=$2 problem=
  shift 2
  count=$((count + 1))
  local allowed is_allowed=
  for allowed; do [[ $allowed == "$status" ]] && is_allowed=yes; done
  [[ $is_allowed ]] || problem="status $status, expected one of: $*; $(tail -n 1 "$work/log")"
  local not_whole
  not_whole=$([[ -d $folder ]] && python3 "$check" "$folder" | head -n 2) || true
  [[ -z $not_whole ]] || problem+=" $not_whole"
  if [[ -n $problem ]]; then
    bad=$((bad + 1))
    echo "  $attack, try $count: $problem" >&2
  fi
  rm -rf "$folder"
}

# run ARGUMENT...: edvo run on the sequence into $work/out, its words in $work/log.
run() {
  "$edvo" run "$work/room" -o "$work/out" --quiet --no-report "$@" >"$work/log" 2>&1
}

random_seconds() { # up to the time of a whole run
  printf '0.%03d' $((RANDOM % 1000))
}

attack_killed() {
  for ((i = 0; i < tries; ++i)); do
    "$edvo" run "$work/room" -o "$work/out" --quiet --no-report >"$work/log" 2>&1 & local pid=$!
    sleep "$(random_seconds)"
    kill -KILL $pid 2>/dev/null
    wait $pid 2>/dev/null
    judge "$work/out" $? 0 137
  done
}

attack_stopped() {
  for ((i = 0; i < tries; ++i)); do
    "$edvo" run "$work/room" -o "$work/out" --quiet >"$work/log" 2>&1 & local pid=$!
    sleep "$(random_seconds)"
    kill -TERM $pid 2>/dev/null
    wait $pid
    judge "$work/out" $? 0 130 143
  done
}

attack_full() { # at each of 50 writes, half of it still fits
  for ((i = 1; i <= 50; ++i)); do
    FAIL_AT=$i LD_PRELOAD=$work/failing_write.so run
    judge "$work/out" $? 7
  done
}

attack_failing() { # a disk that answers with an input/output error
  for ((i = 1; i <= 130; i += 4)); do
    FAIL_AT=$i FAIL_WITH=5 LD_PRELOAD=$work/failing_write.so run
    judge "$work/out" $? 7 0
  done
}

attack_readonly() { # for root, no permission stops; a folder that cannot be made does
  local place
  for place in /proc/none /sys/none /dev/null/none; do
    "$edvo" run "$work/room" -o $place --quiet >"$work/log" 2>&1
    judge "$work/none" $? 7
  done
}

attack_handles() {
  for n in 4 5 6 8 10 12 16 24 32 64; do
    (ulimit -n $n && run)
    judge "$work/out" $? 0 3 5 6 7 9 10 127
  done
}

attack_memory() { # [kB] from where the system cannot load the program up to where it runs
  for ((kb = 100000; kb <= 1500000; kb += 50000)); do
    (ulimit -v $kb && run)
    judge "$work/out" $? 0 10 127
  done
}

attack_locale() {
  for name in C POSIX C.UTF-8 de_DE.UTF-8 tr_TR.UTF-8 no_SUCH; do
    LC_ALL=$name run
    judge "$work/out" $? 0
  done
}

attack_paths() {
  local name
  for name in ' a b ' 'quote"'"'" '-o' $'new\nline' $'esc\e[31m' $'latin\xe9' 'häß中' '$(x)' '%s{}'; do
    rm -rf "${work:?}/p" && mkdir "$work/p" && cp -r "$work/room" "$work/p/$name"
    (cd "$work/p" && env -u HOME -u XDG_CACHE_HOME "$edvo" run "./$name" -o "$work/p/o/$name" >"$work/log" 2>&1)
    local status=$?
    if LC_ALL=C grep -q $'\e' "$work/log"; then status="$status with an escape on the terminal"; fi
    judge "$work/p/o/$name" "$status" 0
  done
}

attack_twice() { # two runs into one folder: whichever comes second is refused
  local first second
  for ((i = 0; i < tries / 10 + 1; ++i)); do
    run & local pid=$!
    sleep 0.1
    "$edvo" run "$work/room" -o "$work/out" --quiet --no-report >"$work/log" 2>&1
    second=$?
    wait $pid
    first=$?
    judge "$work/out" "$first and $second" "0 and 7" "7 and 0"
  done
}

attack_removed() { # the folder is removed or moved away in the middle
  for ((i = 0; i < tries / 10 + 1; ++i)); do
    run & local pid=$!
    while [[ ! -s $work/out/trajectory.tum ]] && kill -0 $pid 2>/dev/null; do sleep 0.01; done
    if ((i % 2)); then rm -rf "$work/out"; else mv "$work/out" "$work/away"; fi
    wait $pid
    judge "$work/away" $? 7
    rm -rf "$work/out"
  done
}

# judge_same STATUS: the run succeeded, and its poses are those of an undisturbed one.
judge_same() {
  local status=$1
  [[ -d $work/undisturbed ]] ||
    "$edvo" run "$work/room" -o "$work/undisturbed" --quiet --no-report >/dev/null 2>&1
  cmp -s "$work/undisturbed/trajectory.tum" "$work/out/trajectory.tum" ||
    status="$status with other poses than undisturbed"
  judge "$work/out" "$status" 0
}

attack_stalled() { # a network file system that stops for a while, now and then
  for stall in '1 2' '7 30' '50 300' '400 2500'; do
    read -r every ms <<<"$stall"
    STALL_EVERY=$every STALL_MS=$ms LD_PRELOAD=$work/slow_system.so run
    judge_same $?
  done
}

attack_short() { # reads and writes of a few bytes, and interrupted ones
  for bytes in 1 13 4096; do
    SHORT_BYTES=$bytes LD_PRELOAD=$work/slow_system.so run
    judge_same $?
  done
  for every in 2 3 11; do
    INTERRUPT_EVERY=$every LD_PRELOAD=$work/slow_system.so run
    judge_same $?
  done
}

attack_clock() { # the time of day jumps to and fro: seconds, a day, years
  for jump in 2 86400 100000000; do
    CLOCK_JUMP=$jump LD_PRELOAD=$work/slow_system.so run
    judge_same $?
  done
}

for attack in "${attacks[@]}"; do
  count=0 bad=0
  "attack_$attack" 2> >(grep -v -e Killed -e Terminated >&2)
  printf '%-10s %4d tries, %d not as they must be\n' "$attack" "$count" "$bad"
  [[ $bad -eq 0 ]] || failed=1
done
exit "$failed"
