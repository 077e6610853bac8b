#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# build_dram.sh MAKE TARGET: runs MAKE on sim/dram/dram.mk for a file of build/dram, one process at a time.
# Needs the environment of the Makefile, and the source that `setup.sh --dram` fetches.
set -eu
cd "$(dirname "$0")/.."
exec 9>build/dram/lock
flock 9
exec "$1" -f sim/dram/dram.mk -j "$(nproc)" "build/dram/$2"
