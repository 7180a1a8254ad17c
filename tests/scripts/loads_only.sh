#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# loads_only.sh PROGRAM LIBRARY...: fails if PROGRAM needs another library than those named, the C
# and C++ runtime, and edvo's own.
set -euo pipefail
program=$1
shift
runtime='c|m|gcc_s|stdc\+\+|pthread|dl|rt'
allowed="^lib($runtime|edvo_[a-z]+$(printf '|%s' "$@"))\.so|^ld-linux"
needed=$(objdump -p "$program" | awk '$1 == "NEEDED" {print $2}')
[[ -n $needed ]] || { echo "$program names no library" >&2; exit 1; }
if others=$(grep -Ev "$allowed" <<<"$needed"); then
  echo "$program also needs: $others" >&2
  exit 1
fi
