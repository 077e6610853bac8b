#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# vendor.sh TOOL FOLDER KEY=VALUE...: builds the block in FOLDER with vivado or quartus; a tool that is not on
# PATH is said in one sentence, with status 2.
set -euo pipefail
tool=$1 folder=$2
shift 2
script=constraints/$tool/build.tcl
case $tool in
  vivado) program=vivado command=(vivado -mode batch -nojournal -nolog -notrace -source "$script" -tclargs) ;;
  quartus) program=quartus_sh command=(quartus_sh -t "$script") ;;
esac
command -v "$program" >/dev/null || {
  echo "make $tool: $program is not on PATH; source the settings of your installation first (docs/parts.md)" >&2
  exit 2
}
exec "${command[@]}" "folder=$folder" "$@"
