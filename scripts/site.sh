#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the documents as a site in build/site, with mkdocs-material in build/venv. A broken link ends
# it. `python3 -m http.server -d build/site` shows it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

python=build/venv/bin/python
[[ -x $python ]] || "${PYTHON:-/usr/bin/python3}" -m venv build/venv
export PIP_DISABLE_PIP_VERSION_CHECK=1
"$python" -m pip install --quiet 'mkdocs-material>=9.5'

# The pages lie where they lie in the repository, with the files that they link.
pages=build/site-pages
rm -rf "$pages"
mkdir -p "$pages"
cp -r docs examples configs models workflow ros2 training scripts *.md LICENSE CITATION.cff "$pages"
export NO_MKDOCS_2_WARNING=1
exec "$python" -m mkdocs build --quiet --strict
