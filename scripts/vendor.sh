#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# vendor.sh TOOL KEY=VALUE...: runs constraints/TOOL/build.tcl, of vivado or quartus, with these arguments.
# vendor.sh TOOL: only whether the tool is on PATH; a missing one is said in one sentence, with status 2.
set -euo pipefail
cd "$(dirname "$0")/.."
tool=$1
shift
script=constraints/$tool/build.tcl
case $tool in
  vivado) command=(vivado -mode batch -nojournal -nolog -notrace -source "$script" -tclargs) ;;
  quartus) command=(quartus_sh -t "$script") ;;
esac
command -v "${command[0]}" >/dev/null || {
  echo "make $tool: ${command[0]} is not on PATH; source the settings of your installation first (docs/parts.md)" >&2
  exit 2
}
[[ $# -eq 0 ]] || exec "${command[@]}" "$@"
