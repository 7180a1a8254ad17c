# SPDX-License-Identifier: MIT
# To be sourced, as root: a bare Debian in a folder.

# prepare_root SUITE FOLDER makes it where there is none, lets it reach packages as this machine
# does, and mounts /proc and /dev there until the script ends. The folder is kept.
prepare_root() {
  local suite=$1 root=$2 shared
  [[ -e $root/bin/bash ]] || debootstrap --variant=minbase "$suite" "$root"
  cp -r /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/"
  cp /etc/resolv.conf "$root/etc/"
  [[ ! -e /etc/pip.conf ]] || cp /etc/pip.conf "$root/etc/"
  mkdir -p "$root/etc/ssl/certs"
  [[ ! -e /etc/ssl/certs/ca-certificates.crt ]] ||
    cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
  for shared in proc dev; do mount --bind "/$shared" "$root/$shared"; done
  # shellcheck disable=SC2064  # the folder as it is now
  trap "umount '$root/proc' '$root/dev'" EXIT
}
