#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# show_waves.sh UNIT [FST CONFIG]: names the FST, else the newest of the tests of units, writes its view
# beside it (scripts/wave_view.py), and opens both where a display and a viewer exist.  CONFIG is the
# folder of the configuration.  GTKWave is taken before Surfer.  Needs the environment of the Makefile.
set -u
unit=$1
fst=${2:-$(find build/unit -name dump.fst -printf '%T@ %p\n' 2>/dev/null | sort -n | tail -n 1 | cut -d' ' -f2-)}
[ -n "$fst" ] || exit 0
if [ $# -ge 3 ]; then
  config=$3
else # tb/agents/bench.py makes these folders
  config=${fst%/*/*}/config
  unit=$(basename "${fst%/*/*/*}")
fi
echo "waves: $fst"
if command -v gtkwave >/dev/null; then
  view=${fst%/*}/view.gtkw
  python scripts/wave_view.py "$fst" --unit "$unit" --config "$config" --out "$view" || exit 0
  echo "waves: gtkwave $fst $view"
  [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] || gtkwave "$fst" "$view" >/dev/null 2>&1 &
elif command -v surfer >/dev/null; then
  view=${fst%/*}/view.sucl
  python scripts/wave_view.py "$fst" --unit "$unit" --config "$config" --surfer --out "$view" || exit 0
  echo "waves: surfer --command-file $view $fst"
  [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] || surfer --command-file "$view" "$fst" >/dev/null 2>&1 &
else
  echo "waves: GTKWave or Surfer opens it, and neither is here; 'scripts/setup.sh --extra' installs GTKWave"
fi
