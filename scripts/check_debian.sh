#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs scripts/demo.sh and scripts/test.sh in a bare Debian of another release, made by debootstrap:
# scripts/check_debian.sh bookworm|trixie FOLDER. As root; FOLDER is kept.
set -euo pipefail
suite=$1 root=$2
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

source "$repository/scripts/bare_root.sh"
prepare_root "$suite" "$root"
rm -rf "$root/edvo"
mkdir "$root/edvo"
git -C "$repository" archive HEAD | tar -x -C "$root/edvo"
chroot "$root" bash -c 'cd /edvo && scripts/demo.sh && echo "demo: $SECONDS s" && SECONDS=0 &&
                        scripts/test.sh && echo "test: $SECONDS s"'
