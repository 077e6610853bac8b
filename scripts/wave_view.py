#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Write the view of a unit's dump: its streams, its other ports and its state, in groups.

The groups come from the ports that the RTL declares, the names and widths from the dump, so a view
always fits both.  Clock and reset stand first; then each stream, valid before ready before what
goes with them; then the other ports; then the registers of the unit, states first.  Binary32
numbers (`fp_t`, and the operands of operators) are shown as numbers, other formats in hex, enums by
name.

A view for GTKWave is a save file, one for Surfer (`--surfer`) a file of commands.

Usage: scripts/wave_view.py DUMP.fst --unit UNIT --config FOLDER [--surfer] --out FILE
"""

import argparse
import gzip
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

from pyslang import ast, driver

ROOT = Path(__file__).resolve().parents[1]
RTL = ROOT / "rtl"


class ViewError(Exception):
    """One sentence for the user."""


@dataclass
class Group:
    """Rows that stand together."""

    name: str
    ports: list[str] = field(default_factory=list)


@dataclass
class Variable:
    """A variable of a dump: its path as GTKWave writes it, and what it holds."""

    path: str
    bits: int
    enum: bool


# --- the RTL ------------------------------------------------------------------------------------


@dataclass
class Unit:
    """What the RTL says of a unit: its ports in order, and which of its variables are floats."""

    ports: list[str]
    floats: set[str]


def read_unit(name: str, config: Path) -> Unit:
    """Ports and floats of module `name`; `config` is a folder that scripts/configure.py wrote."""
    files = sorted([*RTL.rglob(f"{name}.sv"), *(ROOT / "tb").rglob(f"{name}.sv")])
    if not files:
        raise ViewError(f"{name}: there is no {name}.sv in rtl/ or tb/")
    slang = driver.Driver()
    slang.addStandardArgs()
    packages = [RTL.parent / p for p in (RTL / "ti.f").read_text().split() if p.endswith("_pkg.sv")]
    own = [config / "ti_config_pkg.sv", config / "ti_count_pkg.sv"]
    folders = [f"-I{path}" for path in (config, *sorted(RTL.rglob("*"))) if path.is_dir()]
    # Modules below the unit are not read; their absence is no matter here.
    words = ["slang", "--top", name, "--ignore-unknown-modules", "-DSYNTHESIS", *folders]
    words += map(str, [*own, *packages, files[0]])
    good = slang.parseCommandLine(" ".join(f'"{word}"' for word in words))
    if not (good and slang.processOptions() and slang.parseAllSources()):
        raise ViewError(f"{files[0]}: slang cannot read it")
    tops = slang.createCompilation().getRoot().topInstances
    if not tops:
        raise ViewError(f"{files[0]}: there is no module {name} in it")
    body = tops[0].body
    ports = [port.name for port in body.portList]
    operator = any(p.name == "ExpBits" for p in body.parameters)
    floats = set()
    for symbol in body:
        if symbol.kind in (ast.SymbolKind.Variable, ast.SymbolKind.Net):
            floats |= floats_of(symbol.type, symbol.name)
            if operator and "[Width-1:0]" in str(symbol.declaredType.typeSyntax):
                floats.add(symbol.name)
    return Unit(ports, floats)


def floats_of(kind: ast.Type, path: str) -> set[str]:
    """Paths, without indices, of the floats in a variable of type `kind`."""
    if kind.name == "fp_t":
        return {path}
    kind = kind.canonicalType
    if kind.isArray and not kind.isSimpleBitVector:
        return floats_of(kind.arrayElementType, path)
    if kind.isStruct:
        return set().union(*(floats_of(f.type, f"{path}.{f.name}") for f in kind))
    return set()


def groups(ports: list[str]) -> list[Group]:
    """The groups of a unit with these ports; each port stands in one."""
    clock = Group("clock and reset", [p for p in ports if p in ("clk_i", "rst_ni")])
    other = Group("other ports")
    # By what the names of a stream begin with; operators have `valid_i` with the other inputs.
    streams = {}
    for port in ports:
        found = re.fullmatch(r"(.*?)valid(_[io]|)", port)
        if found:
            prefix, direction = found.groups()
            way = {"_i": "in", "_o": "out", "": "AXI"}[direction]
            name = prefix.rstrip("_")
            streams[prefix or direction] = Group(
                f"{name} ({way})" if name not in ("", way) else way
            )
    for port in ports:
        if port not in clock.ports:
            prefix = max((p for p in streams if port.startswith(p)), key=len, default=port[-2:])
            streams.get(prefix, other).ports.append(port)
    for stream in streams.values():
        stream.ports.sort(key=handshake_first)
    return [group for group in (clock, *streams.values(), other) if group.ports]


def handshake_first(port: str) -> int:
    """0 for a valid, 1 for a ready, 2 for what goes with them."""
    found = re.search(r"(valid|ready)(_[io]|)$", port)
    return ("valid", "ready").index(found[1]) if found else 2


# --- the dump -----------------------------------------------------------------------------------

# Blocks of an FST file that hold the hierarchy, by their compression.
GZIP, LZ4, LZ4_TWICE = 4, 6, 7
SCOPE, UPSCOPE, ATTRIBUTE, ATTRIBUTE_END = 254, 255, 252, 253
ENUM_TABLE = (0, 7)  # type and subtype of the attribute before a variable of an enum


def read_dump(file: Path) -> list[Variable]:
    """The variables of an FST file."""
    data = file.read_bytes()
    at = 0
    while at + 9 <= len(data):
        kind, length = data[at], int.from_bytes(data[at + 1 : at + 9], "big")
        block = data[at + 9 : at + 1 + length]
        if kind in (GZIP, LZ4, LZ4_TWICE):
            return list(variables(hierarchy(kind, block)))
        at += 1 + length
    raise ViewError(f"{file}: no list of variables in it; did the run end early?")


def hierarchy(kind: int, block: bytes) -> bytes:
    size = int.from_bytes(block[:8], "big")
    if kind == GZIP:
        return gzip.decompress(block[8:])
    if kind == LZ4:
        return unpack_lz4(block[8:], size)
    return unpack_lz4(unpack_lz4(block[16:], int.from_bytes(block[8:16], "big")), size)


def unpack_lz4(block: bytes, size: int) -> bytes:
    """An LZ4 block: literals, then a copy from what is already there, again and again."""
    out = bytearray()
    at = 0

    def extended(length):
        nonlocal at
        if length == 15:
            while block[at] == 255:
                length, at = length + 255, at + 1
            length, at = length + block[at], at + 1
        return length

    while at < len(block):
        token, at = block[at], at + 1
        literals = extended(token >> 4)
        out += block[at : at + literals]
        at += literals
        if len(out) >= size:
            break
        distance, at = int.from_bytes(block[at : at + 2], "little"), at + 2
        for _ in range(extended(token & 15) + 4):
            out.append(out[-distance])
    return bytes(out)


def variables(data: bytes):
    """The variables of a hierarchy, in its order."""
    at = 0
    scopes = []
    enum = False

    def text():
        nonlocal at
        end = data.index(0, at)
        found, at = data[at:end].decode(), end + 1
        return found

    def number():
        nonlocal at
        value = shift = 0
        while True:
            byte, at = data[at], at + 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(data):
        tag, at = data[at], at + 1
        if tag == SCOPE:
            at += 1
            scopes.append(text())
            text()  # name of the module
        elif tag == UPSCOPE:
            scopes.pop()
        elif tag == ATTRIBUTE:
            which, at = (data[at], data[at + 1]), at + 2
            name = text()
            number()
            # The table itself has its members in the name; a variable refers to it by number.
            enum = which == ENUM_TABLE and not name
        elif tag != ATTRIBUTE_END:
            at += 1
            # GTKWave writes a range of one bit as an index.
            name = re.sub(r"\[(\d+):\1\]$", r"[\1]", text().replace(" ", ""))
            path = ".".join([*scopes, name])
            bits = number()
            number()  # its values
            yield Variable(path, bits, enum)
            enum = False


# --- the view -----------------------------------------------------------------------------------


def rows(unit: str, known: Unit, dump: list[Variable]) -> list[tuple[str, list[Variable]]]:
    """Groups of variables of the dump; those of a port together, registers behind the ports."""
    scope = scope_of(unit, dump)
    inside = [v for v in dump if v.path.startswith(scope)]
    name_of = {id(v): re.split(r"[.\[]", v.path[len(scope) :])[0] for v in inside}
    shown = []
    for group in groups(known.ports):
        found = [v for port in group.ports for v in inside if name_of[id(v)] == port]
        shown.append((group.name, found))
    state = [v for v in inside if name_of[id(v)].endswith("_q")]
    if not state:  # only wires: those of what is in it
        state = [v for v in inside if re.search(r"_q\b", v.path[len(scope) :])]
    shown.append(("state", sorted(state, key=lambda v: not v.enum)))
    return [(name, found) for name, found in shown if found]


def scope_of(unit: str, dump: list[Variable]) -> str:
    """What the paths of the unit's own variables begin with."""
    for variable in dump:
        found = re.match(rf"(.*\.)?{unit}\.", variable.path)
        if found:
            return found[0]
    raise ViewError(f"{unit}: it is not in the dump")


def is_float(variable: Variable, floats: set[str], scope: str) -> bool:
    """Whether it is a binary32 number; no other format of the project has 32 bits."""
    name = re.sub(r"\[[^\]]*\]", "", variable.path.removeprefix(scope))
    name = re.sub(
        r"\b(\w+)\.\1\b", r"\1", name
    )  # the element of an array stands in a scope of its name
    return variable.bits == 32 and name in floats


# Flags of a row in GTKWave's save files.
HEX, BINARY, REAL, ENUM = 0x22, 0x28, 0x40020, 0x100000028
BLANK, CLOSED, BEGIN, END = 0x200, 1 << 22, 1 << 23, 1 << 24
LONG = 40  # rows from which on the state is closed at first


def gtkwave(unit: str, known: Unit, dump: list[Variable]) -> str:
    scope = scope_of(unit, dump)
    shown = rows(unit, known, dump)
    lines = ["[*] Made by scripts/wave_view.py from the ports of the unit."]
    lines += ["[timestart] 0", "[size] 1500 950", "[pos] -1 -1", "*-15.0 -1", f"[treeopen] {scope}"]
    lines += ["[sst_width] 220", "[signals_width] 300", "[sst_expanded] 1"]
    for name, found in shown:
        closed = CLOSED if name == "state" and len(found) > LONG else 0
        lines += [f"@{BEGIN | BLANK | closed:x}", f"-{name}"]
        for variable in found:
            flags = BINARY if variable.bits == 1 else HEX
            if is_float(variable, known.floats, scope):
                flags = REAL
            if variable.enum:
                flags = ENUM
            # GTKWave shows what is behind the last dot: a field without the name of its struct.
            alias = re.sub(r"\b(\w+)\.(?=\1\b)", "", variable.path.removeprefix(scope))
            row = (
                f"+{{{alias.replace('.', '/')}}} {variable.path}" if "." in alias else variable.path
            )
            lines += [f"@{flags:x}", row]
        lines += [f"@{END | BLANK | closed:x}", f"-{name}"]
    return "\n".join(lines) + "\n"


def surfer(unit: str, known: Unit, dump: list[Variable]) -> str:
    lines = []
    for name, found in rows(unit, known, dump):
        lines.append("divider_add " + re.sub(r"\W+", "_", name).strip("_"))  # takes one word
        for variable in found:
            lines.append("variable_add " + re.sub(r"\[\d+:\d+\]$", "", variable.path))
    return "\n".join([*lines, "zoom_fit"]) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dump", type=Path)
    parser.add_argument("--unit", required=True, help="module whose view it is")
    parser.add_argument("--config", type=Path, required=True, help="folder of configure.py")
    parser.add_argument("--surfer", action="store_true", help="for Surfer in place of GTKWave")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    try:
        unit = arguments.unit
        known = read_unit(unit, arguments.config)
        write = surfer if arguments.surfer else gtkwave
        arguments.out.write_text(write(unit, known, read_dump(arguments.dump)))
    except (ViewError, OSError) as error:
        print(f"wave_view: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
