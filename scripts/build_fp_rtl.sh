#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Build the test bench of the floating-point RTL for one format: build_fp_rtl.sh E M OUTDIR [KEY=VALUE ...]
# leaves the program OUTDIR/fp_rtl.  The operators have the stages of the configuration `tiny` unless keys
# such as fp_add_stages=5 or rounding=zero say otherwise.  Needs `verilator` and `python` on PATH; CXX, OBJCACHE as usual.
set -eu

if [ $# -lt 3 ]; then
  echo "build_fp_rtl.sh needs a format of two whole numbers, E and M, and a folder: build_fp_rtl.sh 8 23 OUTDIR." >&2
  exit 2
fi
for bits in "$1" "$2"; do
  case $bits in
    '' | *[!0-9]* | ???*)
      echo "The format '$1,$2' is not two whole numbers E,M." >&2
      exit 2
      ;;
  esac
done
if [ "$1" -lt 3 ] || [ "$1" -gt 8 ] || [ "$2" -lt 2 ] || [ "$2" -gt 23 ]; then
  echo "The format ($1,$2) is outside 3 <= E <= 8, 2 <= M <= 23." >&2
  exit 2
fi

root=$(cd "$(dirname "$0")/.." && pwd)
exp_bits=$1
frac_bits=$2
mkdir -p "$3"
out=$(cd "$3" && pwd)
shift 3
export OBJCACHE="${OBJCACHE-$(command -v ccache || true)}"

# One build at a time in a folder.
exec 9> "$out/lock"
flock 9
# What a killed build has left is not trusted.
[ ! -e "$out/unfinished" ] || rm -f "$out"/*.o "$out"/*.a "$out"/*.gch "$out/fp_rtl"
touch "$out/unfinished"

python "$root/scripts/configure.py" tiny "exp_bits=$exp_bits" "frac_bits=$frac_bits" "$@" --out "$out/config"
# The format and modes of the model.
defines=$(python - "$out/config/config.json" <<'END'
import json
import sys

key = json.load(open(sys.argv[1]))
newton = key["reciprocal"] == "newton"
values = {
    "EXP_BITS": key["exp_bits"],
    "FRAC_BITS": key["frac_bits"],
    "TOWARD_ZERO": int(key["rounding"] == "zero"),
    "FLUSH": int(key["subnormals"] == "flush"),
    "TABLE_BITS": key["rcp_table_bits"] * newton,
    "NEWTON_STEPS": key["rcp_newton_steps"] * newton,
}
print(*(f"-DTI_{name}={value}" for name, value in values.items()))
END
)

verilator --cc --exe --build -j 2 --assert --quiet -Wall -O3 \
  --Mdir "$out" -o fp_rtl --top-module ti_fp_top -GExpBits="$exp_bits" -GFracBits="$frac_bits" \
  -I"$root/rtl/common" -I"$out/config" "$root/lint/verilator.vlt" "$out/config/ti_config_pkg.sv" \
  "$root/rtl/fp/ti_fp_pkg.sv" "$root/rtl/fp/ti_fp_add.sv" "$root/rtl/fp/ti_fp_mul.sv" \
  "$root/rtl/fp/ti_fp_newton.sv" "$root/rtl/fp/ti_fp_rcp.sv" "$root/rtl/fp/ti_fp_cmp.sv" "$root/sim/fp/ti_fp_top.sv" \
  "$root/sim/fp/fp_rtl.cpp" "$root/sim/fp/testfloat_file.cpp" "$root/sw/base/format.cpp" \
  -CFLAGS "-std=c++20 -ffp-contract=off -I$root/sw -I$root/sim/fp" \
  -CFLAGS "$defines" -MAKEFLAGS OPT_FAST=-O2
rm "$out/unfinished"
