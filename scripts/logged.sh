#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# logged.sh LOG WHAT COMMAND...: prints WHAT and runs the command with its output in LOG; when it
# fails, shows the end of LOG.  With SAY_AFTER=n in the environment, WHAT is printed only of a command
# that takes longer than n seconds.
log=$1
what=$2
shift 2
mkdir -p "$(dirname "$log")"
timer=
if [ -n "$SAY_AFTER" ]; then
  (trap 'kill $!; exit' TERM; sleep "$SAY_AFTER" & wait $! && echo "$what") &
  timer=$!
else
  echo "$what"
fi
"$@" >"$log" 2>&1 </dev/null
status=$?
[ -z "$timer" ] || kill "$timer" 2>/dev/null
[ "$status" -eq 0 ] && exit 0
tail -n 30 "$log" >&2
echo "${what%% (*} failed; the whole output is in $log" >&2
exit 2
