#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds edvo::odometry for 64-bit ARM and runs its tests (core, image, features, align, window)
# under qemu. As root: the libraries come into build-arm64/sysroot by debootstrap.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages scripts/packages_arm64.txt
export EDVO_SYSROOT=$PWD/build-arm64/sysroot
export PKG_CONFIG_LIBDIR=$EDVO_SYSROOT/usr/lib/aarch64-linux-gnu/pkgconfig:$EDVO_SYSROOT/usr/share/pkgconfig
export PKG_CONFIG_SYSROOT_DIR=$EDVO_SYSROOT

if [[ ! -e $EDVO_SYSROOT.made ]]; then
  rm -rf "$EDVO_SYSROOT"
  # Unpacks what a system needs and downloads the rest, which is unpacked here: nothing is run.
  debootstrap --foreign --arch=arm64 --variant=minbase \
    --include=libeigen3-dev,libopencv-core-dev,libopencv-imgproc-dev,libfmt-dev,libtomlplusplus-dev,libgmock-dev,libgtest-dev,libc6-dev,libstdc++-12-dev \
    bookworm "$EDVO_SYSROOT"
  for package in "$EDVO_SYSROOT"/var/cache/apt/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$package" | tar -x --keep-directory-symlink -C "$EDVO_SYSROOT"
  done
  # Links to files of the root would lead out of it.
  find "$EDVO_SYSROOT/usr/lib" "$EDVO_SYSROOT/etc/alternatives" -lname '/*' -print0 |
    while IFS= read -r -d '' link; do
      ln -sfr "$EDVO_SYSROOT$(readlink "$link")" "$link"
    done
  # What update-alternatives would do.
  ln -sf blas/libblas.so.3 lapack/liblapack.so.3 "$EDVO_SYSROOT/usr/lib/aarch64-linux-gnu/"
  touch "$EDVO_SYSROOT.made"
fi

cmake -S . -B build-arm64 -G Ninja -DCMAKE_BUILD_TYPE=Release -DEDVO_ODOMETRY_ONLY=ON \
      -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/arm64.cmake"
ninja -C build-arm64 -j "$(parallel_jobs)"
ctest --test-dir build-arm64 --parallel "$(parallel_jobs)" --output-on-failure --no-tests=error
