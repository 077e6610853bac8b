# SPDX-License-Identifier: Apache-2.0
"""A configuration as a block for block designs: plain Verilog, IP-XACT, and all sources.

`ti_top_wrapper.v` is `ti_top` with a set of scalar ports for each core (`m00_axi_*`) and stream
(`s00_axis_ray_*`, `m00_axis_hit_*`); `component.xml` (IEEE 1685-2014) names its bus interfaces.
The sources, those of the configuration too, are copied to `src` beside them, and
`ti_top_wrapper.f` lists them in the order of `rtl/ti.f`, so that the folder needs nothing else.

Usage: scripts/wrapper.py NAME_OR_PATH [KEY=VALUE ...] --out DIR
"""

import argparse
import shutil
import sys
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

import configure
from config_schema import ConfigError

ROOT = Path(__file__).resolve().parents[1]
NAME = "ti_top_wrapper"
VERSION = "1.0"
REGISTERS = "registers"  # the memory map
REGISTER_BITS = 8  # of an address behind s_axil
SPACE = "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"
# The definition of each kind of interface: vendor, library, name, version.
KINDS = {
    "axi4": ("amba.com", "AMBA4", "AXI4", "r0p0_0"),
    "axi4lite": ("amba.com", "AMBA4", "AXI4Lite", "r0p0_0"),
    "axi4stream": ("amba.com", "AMBA4", "AXI4Stream", "r0p0_1"),
    "clock": ("xilinx.com", "signal", "clock", "1.0"),
    "reset": ("xilinx.com", "signal", "reset", "1.0"),
    "interrupt": ("xilinx.com", "signal", "interrupt", "1.0"),
}
WRITE_READ = [
    ("awvalid", 0, 1), ("awready", 1, 1), ("awaddr", 0, REGISTER_BITS), ("awprot", 0, 3),
    ("wvalid", 0, 1), ("wready", 1, 1), ("wdata", 0, 32), ("wstrb", 0, 4),
    ("bvalid", 1, 1), ("bready", 0, 1), ("bresp", 1, 2),
    ("arvalid", 0, 1), ("arready", 1, 1), ("araddr", 0, REGISTER_BITS), ("arprot", 0, 3),
    ("rvalid", 1, 1), ("rready", 0, 1), ("rdata", 1, 32), ("rresp", 1, 2),
]  # fmt: skip


@dataclass
class Bus:
    """An interface: its signals, (name, whether an output, width), are ports `<name>_<signal>`."""

    name: str
    kind: str
    master: bool
    signals: list[tuple[str, int, int]]
    top: str  # prefix of the vectors of `ti_top` of which it is an element; "" for ports of one
    parameters: dict[str, str] = field(default_factory=dict)

    def port(self, signal: str) -> str:
        return f"{self.name}_{signal}" if signal else self.name


def buses(config: dict) -> list[Bus]:
    """The interfaces of a configuration."""
    line, identity = 8 * config["line_bytes"], (config["max_reads"] - 1).bit_length()
    read = [
        ("arvalid", 1, 1), ("arready", 0, 1), ("arid", 1, identity),
        ("araddr", 1, config["addr_bits"]), ("arlen", 1, 8), ("arsize", 1, 3), ("arburst", 1, 2),
        ("arlock", 1, 1), ("arcache", 1, 4), ("arprot", 1, 3), ("arqos", 1, 4),
        ("rvalid", 0, 1), ("rready", 1, 1), ("rid", 0, identity), ("rdata", 0, line),
        ("rresp", 0, 2), ("rlast", 0, 1),
    ]  # fmt: skip
    memories = [f"m{core:02}_axi" for core in range(config["cores"])]
    rays = [f"s{stream:02}_axis_ray" for stream in range(config["streams"])]
    hits = [f"m{stream:02}_axis_hit" for stream in range(config["streams"])]

    def stream(name: str, master: bool) -> Bus:
        signals = [
            ("tvalid", master, 1), ("tready", not master, 1),
            ("tdata", master, 256), ("tlast", master, 1),
        ]  # fmt: skip
        return Bus(name, "axi4stream", master, signals, f"{name[0]}{name[3:]}")

    own = config["stream_clock"] == "own"
    beside = [] if own else [bus for pair in zip(rays, hits, strict=True) for bus in pair]
    clocks = [clock("aclk", ["s_axil", *memories, *beside], aclk=True)]
    if own:
        clocks += [
            clock(f"axis{i:02}_aclk", [rays[i], hits[i]], top="axis_aclk") for i in range(len(rays))
        ]
    return [
        *clocks,
        Bus("aresetn", "reset", False, [("", 0, 1)], "", {"POLARITY": "ACTIVE_LOW"}),
        Bus("irq", "interrupt", True, [("", 1, 1)], "", {"SENSITIVITY": "LEVEL_HIGH"}),
        Bus("s_axil", "axi4lite", False, WRITE_READ, ""),
        *(stream(name, False) for name in rays),
        *(stream(name, True) for name in hits),
        *(Bus(name, "axi4", True, read, "m_axi") for name in memories),
    ]


def clock(name: str, of: list[str], top: str = "", aclk: bool = False) -> Bus:
    reset = {"ASSOCIATED_RESET": "aresetn"} if aclk else {}
    return Bus(name, "clock", False, [("", 0, 1)], top, {"ASSOCIATED_BUSIF": ":".join(of), **reset})


# --- Verilog ------------------------------------------------------------------------------------


def verilog(name: str, machine: str, all_buses: list[Bus]) -> str:
    """The wrapper."""
    ports, connections = [], {}
    for bus in all_buses:
        for signal, output, width in bus.signals:
            extent = f" [{width - 1}:0]" if width > 1 else ""
            text = f"{'output' if output else 'input'} wire{extent} {bus.port(signal)}"
            if bus.parameters:  # clock, reset and interrupt, for Vivado
                values = ", ".join(f"{key} {value}" for key, value in bus.parameters.items())
                vendor, library, kind, version = KINDS[bus.kind]
                info = f"{vendor}:{library}:{kind}:{version} {bus.name} {logical(bus, signal)}"
                text = (
                    f'(* X_INTERFACE_INFO = "{info}", X_INTERFACE_PARAMETER = "{values}" *)\n'
                    f"  {text}"
                )
            ports.append(text)
            prefix = bus.top or bus.name
            top = f"{prefix}_{signal}" if signal else prefix
            connections.setdefault(top, []).append(bus.port(signal))
    # Without clocks of their own `ti_top` does not look at those of the streams.
    if "axis_aclk" not in connections:
        streams = len(connections["s_axis_ray_tvalid"])
        connections["axis_aclk"] = [f"{{{streams}{{1'b0}}}}"]
    body = ",\n".join(
        f"    .{top}({parts[0] if len(parts) == 1 else '{' + ', '.join(reversed(parts)) + '}'})"
        for top, parts in connections.items()
    )
    return (
        "// SPDX-License-Identifier: Apache-2.0\n\n"
        f"// `ti_top` of the configuration {name} (machine {machine}), a set of ports for each\n"
        "// core and stream; written by scripts/wrapper.py.\n"
        f"module {NAME} (\n  " + ",\n  ".join(ports) + "\n);\n\n"
        f"  ti_top u_top (\n{body}\n  );\n\nendmodule\n"
    )


def logical(bus: Bus, signal: str) -> str:
    """The name of a signal in the definition of its interface."""
    return {"clock": "CLK", "reset": "RST", "interrupt": "INTERRUPT"}.get(bus.kind, signal.upper())


# --- IP-XACT ------------------------------------------------------------------------------------


def element(parent: ET.Element, tag: str, text: str | None = None, **attributes: str):
    made = ET.SubElement(parent, f"{{{SPACE}}}{tag}", attributes)
    made.text = text
    return made


def reference(parent: ET.Element, tag: str, kind: str, suffix: str = "") -> None:
    vendor, library, name, version = KINDS[kind]
    element(parent, tag, vendor=vendor, library=library, name=name + suffix, version=version)


def component(name: str, config: dict, all_buses: list[Bus], files: list[str]) -> str:
    """`component.xml`; elements are in the order of the standard's schema."""
    ET.register_namespace("ipxact", SPACE)
    top = ET.Element(f"{{{SPACE}}}component")
    identity = {"vendor": "ti-engine", "library": "ray_tracing", "name": NAME, "version": VERSION}
    for tag, text in identity.items():
        element(top, tag, text)
    interfaces = element(top, "busInterfaces")
    for bus in all_buses:
        add_bus(interfaces, bus)
    spaces = element(top, "addressSpaces")
    space = element(spaces, "addressSpace")
    element(space, "name", "memory")
    element(space, "range", f"'h{1 << config['addr_bits']:x}")
    element(space, "width", str(8 * config["line_bytes"]))
    maps = element(top, "memoryMaps")
    memory_map = element(maps, "memoryMap")
    element(memory_map, "name", REGISTERS)
    block = element(memory_map, "addressBlock")
    element(block, "name", "ti_regs")
    element(block, "baseAddress", "0")
    element(block, "range", str(1 << REGISTER_BITS))
    element(block, "width", "32")
    element(block, "usage", "register")
    add_model(top, all_buses)
    sets = element(top, "fileSets")
    sources = element(sets, "fileSet")
    element(sources, "name", "sources")
    for path in files:
        file = element(sources, "file")
        element(file, "name", path)
        element(file, "fileType", "verilogSource" if path == f"{NAME}.v" else "systemVerilogSource")
        if path.endswith(".svh"):
            element(file, "isIncludeFile", "true")
    element(top, "description", f"Ray traversal and intersection engine, configuration {name}")
    ET.indent(top)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(top, encoding="unicode") + "\n"


def add_bus(parent: ET.Element, bus: Bus) -> None:
    made = element(parent, "busInterface")
    element(made, "name", bus.name)
    reference(made, "busType", bus.kind)
    abstraction = element(element(made, "abstractionTypes"), "abstractionType")
    reference(abstraction, "abstractionRef", bus.kind, "_rtl")
    maps = element(abstraction, "portMaps")
    for signal, _, _ in bus.signals:
        port_map = element(maps, "portMap")
        element(element(port_map, "logicalPort"), "name", logical(bus, signal))
        element(element(port_map, "physicalPort"), "name", bus.port(signal))
    mode = element(made, "master" if bus.master else "slave")
    if bus.kind == "axi4":
        element(mode, "addressSpaceRef", addressSpaceRef="memory")
    if bus.kind == "axi4lite":
        element(mode, "memoryMapRef", memoryMapRef=REGISTERS)
    if bus.parameters:
        parameters = element(made, "parameters")
        for key, value in bus.parameters.items():
            identity = f"{bus.name}.{key}"
            parameter = element(parameters, "parameter", parameterId=identity, type="string")
            element(parameter, "name", key)
            element(parameter, "value", value)


def add_model(top: ET.Element, all_buses: list[Bus]) -> None:
    model = element(top, "model")
    view = element(element(model, "views"), "view")
    element(view, "name", "rtl")
    element(view, "componentInstantiationRef", "rtl")
    instantiation = element(element(model, "instantiations"), "componentInstantiation")
    element(instantiation, "name", "rtl")
    element(instantiation, "language", "Verilog")
    element(instantiation, "moduleName", NAME)
    element(element(instantiation, "fileSetRef"), "localName", "sources")
    ports = element(model, "ports")
    for bus in all_buses:
        for signal, output, width in bus.signals:
            port = element(ports, "port")
            element(port, "name", bus.port(signal))
            wire = element(port, "wire")
            element(wire, "direction", "out" if output else "in")
            if width > 1:
                vector = element(element(wire, "vectors"), "vector")
                element(vector, "left", str(width - 1))
                element(vector, "right", "0")


# --- Files --------------------------------------------------------------------------------------


def sources(configuration: configure.Configuration) -> dict[str, str]:
    """Name and text of all sources, in the order in which they are read."""
    written = {k: v for k, v in configuration.files_of_machine().items() if not k.endswith(".hpp")}
    headers = {path.name: path.read_text() for path in sorted(ROOT.glob("rtl/common/*.svh"))}
    lines = (ROOT / "rtl/ti.f").read_text().split()
    rtl = [ROOT / line for line in lines if not line.startswith("+")]
    macros = {k: v for k, v in written.items() if k.endswith(".svh")}
    return macros | headers | written | {path.name: path.read_text() for path in rtl}


def write(configuration: configure.Configuration, out: Path) -> None:
    """Make `out` hold the block and nothing else in its `src`."""
    config, all_buses = configuration.values, buses(configuration.values)
    texts = sources(configuration)
    shutil.rmtree(out / "src", ignore_errors=True)
    (out / "src").mkdir(parents=True)
    for name, text in texts.items():
        (out / "src" / name).write_text(text)
    (out / f"{NAME}.v").write_text(verilog(configuration.name, configuration.machine, all_buses))
    files = [*(f"src/{name}" for name in texts), f"{NAME}.v"]
    listed = [path for path in files if not path.endswith(".svh")]
    (out / f"{NAME}.f").write_text("\n".join(["+incdir+src", *listed]) + "\n")
    (out / "component.xml").write_text(component(configuration.name, config, all_buses, files))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name_or_path", help="name of a file in configs/, or a path")
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    arguments = parser.parse_args()
    try:
        write(configure.load(arguments.name_or_path, arguments.overrides), arguments.out)
    except ConfigError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    print(arguments.out / "component.xml")
    return 0


if __name__ == "__main__":
    sys.exit(main())
