#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# shared_build.sh SOURCE FOLDER COMPILER: builds the library as shared objects in FOLDER, installs
# it, and builds and runs the example of edvo::odometry against it. With FOLDER beside the folder of
# the static library, the compiler cache has all objects.
set -euo pipefail
source=$1 folder=$2 compiler=$3
here=$(dirname "${BASH_SOURCE[0]}")
cmake -S "$source" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON \
      -DCMAKE_CXX_COMPILER="$compiler" -DEDVO_BUILD_APPS=OFF -DEDVO_BUILD_TESTS=OFF
ninja -C "$folder"
rm -rf "$folder/installed"
cmake --install "$folder" --prefix "$folder/installed"
cmake -S "$source/examples/02_own_camera" -B "$folder/example" -G Ninja \
      -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$folder/installed"
ninja -C "$folder/example"
"$folder/example/own_camera"
"$here/loads_only.sh" "$folder/example/own_camera" opencv_core opencv_imgproc
library=$(find "$folder/installed" -name 'libedvo_odometry.so' | head -1)
"$here/loads_only.sh" "$library" opencv_core opencv_imgproc
