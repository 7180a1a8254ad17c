#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes Debian packages for this release in build/packages: edvo (the program) and libedvo-dev.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages scripts/packages_deb.txt
configure "$@"
build edvo_app
rm -rf build/packages
cpack --config build/CPackConfig.cmake >build/packages.log || { cat build/packages.log >&2; exit 1; }
rm -rf build/packages/_CPack_Packages
ls -lh build/packages/*.deb
