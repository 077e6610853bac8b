# SPDX-License-Identifier: Apache-2.0
"""A block that `scripts/wrapper.py` wrote, as Yosys elaborates it: ports, registers, crossings.

Names of registers are those of the RTL before a tool renames them, so that constraints can be held
against them; `vivado` and `quartus` spell one as those tools do.
"""

import json
import re
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree as ET

from synthesis import YOSYS, MeasureError

TOP = "ti_top_wrapper"
# The engine has one clock, which `registers` sees; without its logic the crossings take no time.
ENGINE = "ti_engine"
MARK = "$driver$"  # in the name of a flop, before that of its register
REGISTER = re.compile(r"\$(al|a|s|)d(lat|)ff")
INPUTS = {"CLK", "EN", "SRST", "ARST", "ALOAD", "AD", "D", "ADDR", "DATA"}
XML = {"i": "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"}


@dataclass(frozen=True, order=True)
class Crossing:
    """From a register, memory or port of one clock to a register of another."""

    start: str
    start_clock: str
    end: str
    end_clock: str


def sources(folder: Path) -> list[str]:
    """What the list of the block names, in its order; folders of headers as +incdir+."""
    return (folder / f"{TOP}.f").read_text().split()


def elaborate(folder: Path, options: str, *commands: str) -> None:
    """Read the block with its hierarchy, then run commands of Yosys."""
    words = ["read_slang --keep-hierarchy -DSYNTHESIS", f"--top {TOP}", options]
    for word in sources(folder):
        words.append(word.replace("+incdir+", "-I"))
    done = subprocess.run(
        [sys.executable, "-c", YOSYS, " ".join(words), *commands],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode or re.search(r"^ERROR:", done.stdout + done.stderr, re.MULTILINE):
        raise MeasureError(f"{folder}: Yosys cannot read it: {(done.stdout + done.stderr)[-2000:]}")


def clocks(folder: Path) -> dict[str, str]:
    """The clock that a port belongs to, by the interfaces of component.xml."""
    root = ET.parse(folder / "component.xml").getroot()
    ports, clock_of = {}, {}
    for bus in root.findall("i:busInterfaces/i:busInterface", XML):
        name = bus.findtext("i:name", None, XML)
        ports[name] = [p.text for p in bus.findall(".//i:physicalPort/i:name", XML)]
        for parameter in bus.findall(".//i:parameter", XML):
            if parameter.findtext("i:name", None, XML).startswith("ASSOCIATED_"):
                for other in parameter.findtext("i:value", None, XML).split(":"):
                    clock_of[other] = name
    return {port: clock_of[name] for name in ports if name in clock_of for port in ports[name]}


def name(cell: dict, cell_name: str) -> str | None:
    """The register that a cell is, or the memory that it writes."""
    if cell["type"] == "$memwr_v2":
        return cell["parameters"]["MEMID"].removeprefix("\\")
    if MARK in cell_name:
        path, _, register = cell_name.rpartition(MARK)
        return re.sub(r"^\$flatten", "", path).replace("\\", "") + register
    return None


class Block:
    """One block."""

    def __init__(self, folder: Path, engine: bool = True):
        """Without the engine it takes a second."""
        self._folder = folder
        whole, flat = folder / "hierarchy.json", folder / "flat.json"
        elaborate(
            folder,
            "" if engine else f"--blackboxed-module {ENGINE}",
            f"write_json {whole.name}",
            f"blackbox {ENGINE} {ENGINE}$*",  # whichever of the two is its name
            f"hierarchy -top {TOP}",
            "flatten; opt_clean",
            f"write_json {flat.name}",
        )
        self._modules = json.loads(whole.read_text())["modules"]
        self._flat = json.loads(flat.read_text())["modules"][TOP]

    def ports(self) -> dict[str, int]:
        """Bits of each port of the wrapper."""
        return {n: len(p["bits"]) for n, p in self._modules[TOP]["ports"].items()}

    def inputs(self) -> set[str]:
        """Those that are inputs."""
        ports = self._modules[TOP]["ports"]
        return {name for name, port in ports.items() if port["direction"] == "input"}

    def clocks(self) -> set[str]:
        """Those that clock something."""
        return set(self.clocks_outside_of_engine().values())

    def cells(self) -> dict[tuple[str, ...], int]:
        """Bits of each register, words of each memory, by path: instances, then the register."""
        found = {}

        def walk(module: str, path: tuple[str, ...]) -> None:
            for cell_name, cell in self._modules[module]["cells"].items():
                if cell["type"] in self._modules:
                    walk(cell["type"], (*path, cell_name))
                elif REGISTER.match(cell["type"]) and MARK in cell_name:
                    found[(*path, cell_name.partition(MARK)[2])] = len(cell["connections"]["Q"])
            for memory, shape in self._modules[module].get("memories", {}).items():
                found[(*path, memory)] = shape["size"]

        walk(TOP, ())
        return found

    def instances(self) -> list[tuple[str, ...]]:
        """Paths of all instances."""
        return list({path[:i]: None for path in self.cells() for i in range(1, len(path))})

    def clocks_of_engine(self) -> set[str]:
        """Ports of the engine's modules that clock something in them; one name is one clock."""
        found, seen = set(), set()

        def walk(module: str) -> None:
            if module in seen:
                return
            seen.add(module)
            ports = {tuple(p["bits"]): n for n, p in self._modules[module]["ports"].items()}
            for cell_name, cell in self._modules[module]["cells"].items():
                inside = cell["type"] in self._modules
                pins = ("clk_i",) if inside else ("CLK",)
                for pin in pins:
                    bits = tuple(cell["connections"].get(pin, ()))
                    if bits and bits != ("x",):
                        found.add(ports.get(bits, f"{module}.{cell_name}"))
                if inside:
                    walk(cell["type"])

        walk(next(m for m in self._modules if re.fullmatch(rf"{ENGINE}(\$.*)?", m)))
        return found

    def crossings(self) -> list[Crossing]:
        """All of them, register by register."""
        return self._crossings.found

    def clocks_outside_of_engine(self) -> dict[str, str]:
        """The clock of each register and memory outside of the engine."""
        return self._crossings.clocks

    @cached_property
    def _crossings(self) -> "Crossings":
        return Crossings(self._flat, clocks(self._folder))


class Crossings:
    """Where a flop looks, through logic, at what another clock moves."""

    def __init__(self, module: dict, clock_of_port: dict[str, str]):
        self._cells = module["cells"]
        self._sources: dict = {}  # bit: {(name, clock)}, of what does not depend on other bits
        self._driver: dict = {}  # bit: cell
        self._clock_names = {}
        for port, value in module["ports"].items():
            if value["direction"] == "input":
                clock = clock_of_port.get(port)
                for bit in value["bits"]:
                    self._clock_names[bit] = port
                    self._sources[bit] = {(port, clock)} if clock else set()
        self.clocks: dict[str, str] = {}
        for cell_name, cell in self._cells.items():
            register = name(cell, cell_name)
            if register:
                self.clocks[register] = self._clock(cell)
            self._add_outputs(cell_name, cell)
        self.found = sorted(self._find())

    def _clock(self, cell: dict) -> str:
        return self._clock_names[cell["connections"]["CLK"][0]]

    def _add_outputs(self, cell_name: str, cell: dict) -> None:
        for pin, bits in cell["connections"].items():
            output = cell.get("port_directions", {}).get(pin) == "output"
            for bit in bits if output else ():
                if REGISTER.match(cell["type"]):
                    self._sources[bit] = {(name(cell, cell_name), self._clock(cell))}
                elif cell["type"].startswith(ENGINE):
                    clock = self._clock_names[cell["connections"]["clk_i"][0]]
                    self._sources[bit] = {(cell_name, clock)}
                else:
                    self._driver[bit] = cell

    def _origins(self, bits: list) -> set:
        """What a set of bits comes from."""
        found, stack, seen = set(), list(bits), set()
        while stack:
            bit = stack.pop()
            if bit in seen or isinstance(bit, str):
                continue
            seen.add(bit)
            if bit in self._sources:
                found |= self._sources[bit]
                continue
            cell = self._driver[bit]
            if cell["type"] == "$memrd_v2":
                memory = cell["parameters"]["MEMID"].removeprefix("\\")
                found.add((memory, self.clocks[memory]))
            for pin, wires in cell["connections"].items():
                if cell["port_directions"][pin] == "input":
                    stack += wires
        return found

    def _find(self) -> set[Crossing]:
        found = set()
        for cell_name, cell in self._cells.items():
            sequential = REGISTER.match(cell["type"]) or cell["type"] == "$memwr_v2"
            if sequential:
                clock, end = self._clock(cell), name(cell, cell_name)
                pins = INPUTS - {"CLK"}
            elif cell["type"].startswith(ENGINE):
                clock, end = self._clock_names[cell["connections"]["clk_i"][0]], cell_name
                pins = {p for p, d in cell["port_directions"].items() if d == "input"} - {"clk_i"}
            else:
                continue
            bits = [bit for pin in pins for bit in cell["connections"].get(pin, ())]
            for start, start_clock in self._origins(bits):
                if start_clock != clock:
                    found.add(Crossing(start, start_clock, end, clock))
        return found


def spell(path: tuple[str, ...], bits: int, tool: str) -> list[str]:
    """The bits of a register, or words of a memory, as a tool names them."""
    *instances, register = path
    if tool == "vivado":
        word, *rest = re.split(r"[.\[]", register.replace("]", ""))
        register = f"{word}_reg" + "".join(f"[{part}]" for part in rest)
    prefix = {"vivado": "/", "quartus": "|"}[tool].join([*instances, register])
    return [prefix] if bits == 1 else [f"{prefix}[{bit}]" for bit in range(bits)]
