#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the packages of scripts/deb.sh in a bare Debian made by debootstrap, runs edvo demo there,
# and builds an example against libedvo-dev: scripts/check_deb.sh FOLDER [SUITE]. As root; FOLDER is
# kept, SUITE is this machine's release unless it is named.
set -euo pipefail
root=$1
suite=${2:-$(. /etc/os-release && echo "$VERSION_CODENAME")}
cd "$(dirname "${BASH_SOURCE[0]}")/.."

source scripts/bare_root.sh
prepare_root "$suite" "$root"

rm -rf "$root/edvo-packages"
mkdir "$root/edvo-packages"
cp build/packages/*.deb "$root/edvo-packages/"
cp -r examples/02_own_camera "$root/edvo-packages/example"
chroot "$root" bash -euc '
  export DEBIAN_FRONTEND=noninteractive
  cd /edvo-packages
  apt-get -q update >/dev/null
  apt-get -qy install --no-install-recommends ./edvo_*.deb >install.log || { cat install.log; exit 1; }
  edvo --version
  test -s /usr/share/man/man1/edvo.1
  bash -n /usr/share/bash-completion/completions/edvo
  edvo demo --quiet -o demo
  test -s demo/report.html
  apt-get -qy install --no-install-recommends ./libedvo-dev_*.deb cmake g++ ninja-build >>install.log ||
    { cat install.log; exit 1; }
  cmake -S example -B example/build -G Ninja >/dev/null
  cmake --build example/build
  example/build/own_camera
  apt-get -qy purge edvo libedvo-dev >>install.log
  test ! -e /usr/bin/edvo'
echo "edvo: the packages install, run and build in $root"
