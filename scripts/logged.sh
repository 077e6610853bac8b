#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# logged.sh LOG WHAT COMMAND...: prints WHAT and runs the command with its output in LOG; when it
# fails, shows the end of LOG.
log=$1
what=$2
shift 2
mkdir -p "$(dirname "$log")"
echo "$what"
"$@" >"$log" 2>&1 </dev/null && exit 0
tail -n 30 "$log" >&2
echo "${what%% (*} failed; the whole output is in $log" >&2
exit 2
