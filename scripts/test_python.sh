#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Python package with `pip install .` into build/venv and runs its tests. What was
# compiled for the program is found again in the compiler's cache. Arguments go to pytest.
#
#   PYTHON=/usr/bin/python3.12 scripts/test_python.sh -k bags
#   scripts/test_python.sh --prepare    # only makes build/venv with what the tests need
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

environment=build/venv
python=$environment/bin/python  # -m pip and so on: a copied checkout's bin/pip is that of its old place
export PIP_DISABLE_PIP_VERSION_CHECK=1

# Everything but edvo itself.
prepare() {
  mkdir -p build
  [[ -x $python ]] || "${PYTHON:-/usr/bin/python3}" -m venv "$environment"
  "$python" -m pip install --quiet wheel setuptools tomli
  mapfile -t requirements < <("$python" scripts/requirements.py test)
  "$python" -m pip install --quiet "${requirements[@]}"
  # Of use only; its tests are left out where it is missing.
  "$python" -m pip install --quiet 'snakemake>=8' || true
  "$python" -m pip install --quiet 'mkdocs-material>=9.5'
}

prepare
[[ ${1:-} != --prepare ]] || exit 0

forget_other_place build-python
# The compiler by the name that it had for the program: the cache tells names apart.
compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' build/CMakeCache.txt 2>/dev/null || true)
[[ -z $compiler ]] || export CXX=$compiler
CMAKE_BUILD_PARALLEL_LEVEL=$(parallel_jobs) \
  "$python" -m pip install --quiet --no-build-isolation '.[test]'

"$python" -m mypy --config-file pyproject.toml
scripts/site.sh
program=build/bin/edvo
[[ -x $program ]] && export EDVO_PROGRAM=$PWD/$program
exec "$python" -m pytest -q -p no:cacheprovider "$@"
