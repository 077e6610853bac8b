#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# show_waves.sh UNIT: names the newest FST, and opens it where a display and a viewer exist.
fst=$(find build/unit -name dump.fst -printf '%T@ %p\n' 2>/dev/null | sort -n | tail -n 1 | cut -d' ' -f2-)
[ -n "$fst" ] || exit 0
echo "waves: $fst"
[ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] || exit 0
if command -v gtkwave >/dev/null; then
  view=sim/waves/$1.gtkw
  [ -f "$view" ] || view=
  gtkwave "$fst" $view >/dev/null 2>&1 &
elif command -v surfer >/dev/null; then
  surfer "$fst" >/dev/null 2>&1 &
else
  echo "waves: no viewer; install gtkwave to see them"
fi
