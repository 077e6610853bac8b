#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# lint.sh: Verilator (three configurations and a second number format in other modes), Verible, clang-format, Ruff.
# Any warning fails.  Needs the environment of the Makefile.
set -u
cd "$(dirname "$0")/.."
failed=0
config=build/lint/$$
trap 'rm -rf "$config"' EXIT

# check WHAT COMMAND...: one line when it is clean, all its output when it is not.
check() {
  what=$1
  shift
  if output=$("$@" 2>&1) && [ -z "$output" ]; then
    echo "lint: $what"
  else
    printf '%s\n' "$output" | head -n 60 >&2
    echo "lint: $what: NOT clean" >&2
    failed=1
  fi
}

elaborate() {
  # shellcheck disable=SC2086  # a name and overrides
  python scripts/configure.py $1 --out "$config" &&
    verilator --lint-only -Wall --quiet-stats -Irtl/common "-I$config" lint/verilator.vlt \
      "$config/ti_config_pkg.sv" "$config/ti_count_pkg.sv" -f rtl/ti.f --top-module ti_top
}

# But what PeakRDL writes.
rtl=$(find rtl tb sim -name '*.sv' ! -name 'ti_regs*.sv' -o -name '*.svh' | sort)
cpp=$(find sw sim tb -name '*.cpp' -o -name '*.hpp' | sort)

for words in tiny small paper "tiny exp_bits=7 frac_bits=16 rounding=zero subnormals=flush counter_snapshot=1 lookup_stages=2" \
  "tiny cores=3 stream_clock=own read_timeout=1000 num_trv=5 num_list=2 num_ist1=3 line_bytes=32 ring_delays=0 counters=0 sync_reset=0 \
early_exit=0 any_hit=0 ray_accumulation=retry stack_depth=0 lookup_stages=5 fill_bytes=16" \
  "tiny stack_depth=6 restart=0 watchdog_steps=100 reciprocal=newton" \
  "tiny triangle_test=np rd_cycles=3" "tiny triangle_test=woop traversal=padded" \
  "tiny triangle_test=woop exp_bits=7 frac_bits=16 rd_cycles=1 early_exit=0" \
  fpga "tiny traversal=padded stack_depth=6 restart=0 any_hit=0 rd_cycles=2 fp_cmp_stages=1"; do
  check "verilator -Wall, $words" elaborate "$words"
done
# shellcheck disable=SC2086  # lists of files without spaces
{
  check "verible-verilog-lint" verible-verilog-lint --rules_config lint/verible.rules \
    --waiver_files lint/verible.waiver $rtl
  check "verible-verilog-format" verible-verilog-format --flagfile=lint/verible-format.flags \
    --verify --inplace $rtl
  check "clang-format" clang-format --dry-run --Werror $cpp
}
check "ruff check" ruff check --quiet
check "ruff format" ruff format --check --quiet
exit $failed
