# SPDX-License-Identifier: MIT
# What demo.sh and test.sh share: packages, configuring, building. To be sourced from the root of
# the repository; everything here may be run again and does only what is missing.

# What was compiled in one clone is found again in another.
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1

fail() {
  echo "edvo: $*" >&2
  exit 1
}

# packages_missing LIST...
packages_missing() {
  comm -23 <(sed 's/#.*//; s/?//' "$@" | xargs -n1 | sort -u) \
    <(dpkg-query -W -f='${db:Status-Abbrev} ${Package}\n' 2>/dev/null |
      sed -n 's/^.i  *//p' | sort -u)
}

# install_packages [LIST...]: what is missing of scripts/packages.txt and the lists.
install_packages() {
  command -v apt-get >/dev/null && command -v dpkg-query >/dev/null ||
    fail "this script installs packages with apt (Debian 12 or 13); elsewhere, install the equivalents" \
         "of scripts/packages.txt, then: cmake --preset release && cmake --build --preset release"
  local missing
  mapfile -t missing < <(packages_missing scripts/packages.txt "$@")
  [[ ${#missing[@]} -gt 0 ]] || return 0

  local as_root=()
  if [[ $EUID -ne 0 ]]; then
    command -v sudo >/dev/null ||
      fail "packages are missing, and there is neither root nor sudo; as root, run:" \
           "apt-get update && apt-get install ${missing[*]}"
    as_root=(sudo)
  fi

  echo "edvo: installing ${#missing[@]} packages: ${missing[*]}"
  local log
  log=$(mktemp)
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q
             -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
  # One unreachable mirror among several does no harm: only the installation decides.
  "${apt[@]}" update >"$log" 2>&1 || true
  # What is only of use is left out where the release does not have it.
  local package
  for package in $(sed -n 's/#.*//; s/?.*//p' scripts/packages.txt "$@"); do
    # All of the output is read: grep -q would end the pipe early, and pipefail would count that.
    [[ -n $(apt-cache policy "$package" | sed -n '/Candidate: [0-9]/p') ]] ||
      mapfile -t missing < <(printf '%s\n' "${missing[@]}" | grep -vx "$package")
  done
  if ! "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >>"$log" 2>&1; then
    grep -m3 -E '^(E|W|Err):' "$log" >&2 || tail -n 3 "$log" >&2
    rm -f "$log"
    fail "could not install these packages: is there a network, and is this Debian 12 or 13?"
  fi
  rm -f "$log"
}

# A compiler takes up to 2 GB with OpenCV's and Eigen's headers: as many jobs as cores and memory.
parallel_jobs() {
  local cores memory_kb
  cores=$(nproc)
  memory_kb=$(sed -n 's/^MemAvailable: *\([0-9]*\) kB/\1/p' /proc/meminfo)
  local fitting=$((${memory_kb:-2097152} / 2097152))
  [[ $fitting -lt 1 ]] && fitting=1
  echo $((cores < fitting ? cores : fitting))
}

# forget_other_place FOLDER: a checkout that was copied or moved brings build folders that name its
# old place.
forget_other_place() {
  local built_from
  built_from=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$1/CMakeCache.txt" 2>/dev/null || true)
  if [[ -n $built_from && $built_from != "$(pwd -P)" ]]; then
    echo "edvo: $1/ was made in $built_from; it is configured anew"
    rm -rf "$1/CMakeCache.txt" "$1/CMakeFiles"
  fi
}

# configure [CMAKE_ARGUMENT...]
configure() {
  local log
  log=$(mktemp)
  forget_other_place build
  if ! cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release "$@" >"$log" 2>&1; then
    cat "$log" >&2
    rm -f "$log"
    fail "configuring failed"
  fi
  rm -f "$log"
}

# build [TARGET...]
build() {
  ninja -C build -j "$(parallel_jobs)" "$@"
}
