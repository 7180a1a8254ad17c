#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Python package with `pip install .` into build/venv and runs its tests. What was
# compiled for the program is found again in the compiler's cache. Arguments go to pytest.
#
#   PYTHON=/usr/bin/python3.12 scripts/test_python.sh -k bags
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

environment=build/venv
[[ -x $environment/bin/python ]] || "${PYTHON:-/usr/bin/python3}" -m venv "$environment"
export PIP_DISABLE_PIP_VERSION_CHECK=1
"$environment/bin/pip" install --quiet 'scikit-build-core>=0.10' 'nanobind>=2.2'
CMAKE_BUILD_PARALLEL_LEVEL=$(parallel_jobs) \
  "$environment/bin/pip" install --quiet --no-build-isolation '.[test]'

"$environment/bin/mypy" --config-file pyproject.toml
program=build/bin/edvo
[[ -x $program ]] && export EDVO_PROGRAM=$PWD/$program
exec "$environment/bin/pytest" -q -p no:cacheprovider "$@"
