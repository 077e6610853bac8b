#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# test.sh [PART_OF_A_NAME]: what `make test` runs, builds first.  Lint, C++, the quick mutants and proofs run
# beside the tests of the RTL, behind them for the processor.  A stage that fails does not hide the
# next ones.  The table of stages is also in build/test/stages.txt, the slowest tests beside it.
# Needs the environment of the Makefile.
set -u
cd "$(dirname "$0")/.."
part=${1:-}
out=build/test
mkdir -p "$out"
rm -f "$out"/stages.txt "$out"/failed.txt "$out"/time.*
# Variables of the `make` above are not for those below.
unset MAKEFLAGS MFLAGS MAKELEVEL MAKEOVERRIDES

# stage WHAT COMMAND...: notes its time, and its name when it fails.
stage() {
  local what=$1 status
  shift
  local TIMEFORMAT="%R %U %S"
  { time "$@" >&3 2>&4; } 3>&1 4>&2 2>"$out/time.$BASHPID"
  status=$?
  awk -v what="$what" '{ printf "%-24s %8.0f %8.0f\n", what, $1, $2 + $3 }' "$out/time.$BASHPID" >>"$out/stages.txt"
  rm "$out/time.$BASHPID"
  [[ $status == 0 ]] || echo "$what" >>"$out/failed.txt"
  return $status
}

# logged WHAT LOG COMMAND...: a stage whose output goes to LOG.
logged() {
  stage "$1" scripts/logged.sh "$2" "test: $1" "${@:3}"
}

beside() {
  if [[ -n "$part" ]]; then
    logged "C++ *$part*" build/sw/ti_tests.log build/sw/ti_tests -tc="*$part*"
    return
  fi
  stage "lint" scripts/lint.sh
  logged "C++" build/sw/ti_tests.log build/sw/ti_tests
  logged "C++ FP against MPFR" build/sw/fp_volume.log build/sw/fp_volume --pairs 200000
  stage "build: sanitizers" make sanitized &&
    logged "C++ with sanitizers" build/sanitize/ti_tests.log build/sanitize/ti_tests
  stage "mutants" make mutants TEST= QUICK=1
  stage "proofs" make formal UNIT= QUICK=1 OUT= PAGE=
}

stage "build: C++, scene" make -s sw build/scenes/knot.ply || exit 1
for config in tiny small; do # whole-engine tests trace on these
  stage "build: engine $config" make engine CONFIG="$config" SET= || exit 1
done

# A group of its own, to end with this script; told when it is done, so that the lines do not mix.
set -m
nice -n 5 bash -c "$(declare -f stage logged beside); part='$part' out='$out'; beside" \
  >"$out/beside.log" 2>&1 </dev/null &
others=$!
set +m
trap 'kill -- -$others 2>/dev/null; exit 130' INT TERM

echo "test: RTL; beside it lint, C++, mutants and proofs"
# TEST would also choose among the cocotb tests of each module.
stage "RTL" env -u TEST pytest -n "$(nproc)" --dist loadfile --no-loadscope-reorder ${part:+-k "$part"}
wait "$others"
cat "$out/beside.log"
if [[ -z "$part" ]]; then
  python scripts/covers.py build/unit >"$out/covers.txt"
  echo "covers: $(tail -n 1 "$out/covers.txt") (all: $out/covers.txt)"
fi

printf '\n%-24s %8s %8s\n' "stage" "seconds" "CPU s"
cat "$out/stages.txt"
awk -v wall="$SECONDS" '{ cpu += $NF } END { printf "%-24s %8.0f %8.0f\n", "all", wall, cpu }' "$out/stages.txt"
if [[ -s "$out/failed.txt" ]]; then
  echo "$(wc -l <"$out/failed.txt") failed: $(paste -sd, "$out/failed.txt" | sed 's/,/, /g')"
  exit 1
fi
