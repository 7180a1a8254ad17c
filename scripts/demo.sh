#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Sets up what is missing, builds the program and runs it on a sequence that it renders itself.
# Arguments go to `edvo demo`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source scripts/setup.sh

install_packages
configure
build edvo_app
exec build/bin/edvo demo "$@"
