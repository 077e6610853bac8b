#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# test.sh [PART_OF_A_NAME]: what `make test` runs once everything is built.  A stage that fails does
# not hide the next ones; the last line is pytest's, or names the earlier stages that failed.
set -u
cd "$(dirname "$0")/.."
part=${1:-}
failed=()

# stage WHAT LOG COMMAND...
stage() {
  scripts/logged.sh "$2" "test: $1" "${@:3}" || failed+=("$1")
}

if [[ -z "$part" ]]; then
  scripts/lint.sh || failed+=(lint)
  stage "C++" build/sw/ti_tests.log build/sw/ti_tests
  stage "C++ with sanitizers" build/sanitize/ti_tests.log build/sanitize/ti_tests
  stage "C++ FP against MPFR" build/sw/fp_volume.log build/sw/fp_volume --pairs 200000
else
  stage "C++ *$part*" build/sw/ti_tests.log build/sw/ti_tests -tc="*$part*"
fi

echo "test: RTL"
# TEST would also choose among the cocotb tests of each module.
env -u TEST pytest -n "$(nproc)" --dist loadfile ${part:+-k "$part"} || failed+=("RTL")

if [[ ${#failed[@]} -gt 0 ]]; then
  echo "${#failed[@]} failed: ${failed[*]}"
  exit 1
fi
