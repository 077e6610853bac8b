#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# build_cpp.sh FOLDER "TARGET ..." [CMAKE_OPTION ...]: builds C++ targets of sw/ by CMake and Ninja in
# FOLDER, one process at a time.  Configures first when the options are new or when it was cut short.
# Needs the environment of the Makefile.
set -eu
cd "$(dirname "$0")/.."
folder=$1
read -ra targets <<<"$2"
shift 2
mkdir -p "$folder"
exec 9>"$folder/lock"
flock 9

wanted=$(printf '%s\n' "$PWD" "$@")
if [[ ! -f "$folder/build.ninja" || "$(cat "$folder/configured.txt" 2>/dev/null)" != "$wanted" ]]; then
  rm -rf "$folder/configured.txt" "$folder/CMakeCache.txt" "$folder/CMakeFiles"
  scripts/logged.sh "$folder/configure.log" "build: configure C++ ($folder)" \
    cmake -S sw -B "$folder" -G Ninja "$@"
  printf '%s\n' "$wanted" >"$folder/configured.txt"
fi
SAY_AFTER=1 exec scripts/logged.sh "$folder/build.log" "build: C++ (${targets[*]})" ninja -C "$folder" -j "$(nproc)" "${targets[@]}"
