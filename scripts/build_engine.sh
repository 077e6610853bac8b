#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# build_engine.sh FOLDER MAKE...: runs MAKE on sim/sim.mk for the engine in FOLDER, one process at a
# time.  What a killed build has left there is not trusted: the next one starts anew.
set -eu
folder=$1
shift
exec 9>"$folder/lock"
flock 9
[[ ! -e "$folder/unfinished" ]] || rm -rf "$folder/verilated" "$folder/obj" "$folder/libti_rtl.so"
touch "$folder/unfinished"
status=0
"$@" -f sim/sim.mk engine="$folder" || status=$?
rm "$folder/unfinished"
exit $status
