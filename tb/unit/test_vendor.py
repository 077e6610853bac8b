# SPDX-License-Identifier: Apache-2.0
"""Scripts for vendors' tools read what they should; constraints name what the design has."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import plain_verilog
import pyslang
import pytest
from agents.bench import ROOT
from elaborated import Block, sources
from vendor.tcl import Tcl, names, values

CONSTRAINTS = ROOT / "constraints"
COMMON = CONSTRAINTS / "common"
BOARDS = {
    "vivado": ["alveo_u55c", "arty_a7_100t", "kv260"],
    "quartus": ["de10_nano"],
    "open": ["ecp5_evn", "ulx3s"],
}
# Several cores and streams, each with a clock of its own.
OWN = ["tiny", "cores=2", "streams=2", "stream_clock=own"]
SUFFIX = {"vivado": "tcl", "quartus": "sdc"}


def make_ip(folder, *words):
    command = [sys.executable, ROOT / "scripts/wrapper.py", *words, "--out", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """(folder, block) with clocks of their own, without what is in the engine."""
    folder = make_ip(tmp_path_factory.mktemp("own"), *OWN)
    return folder, Block(folder, engine=False)


@pytest.fixture(scope="module")
def whole(own, tmp_path_factory):
    """The same with the engine."""
    folder = shutil.copytree(own[0], tmp_path_factory.mktemp("whole") / "ip")
    return folder, Block(folder)


@pytest.fixture(scope="module")
def core(tmp_path_factory):
    """(folder, block) with one clock."""
    folder = make_ip(tmp_path_factory.mktemp("core"), "tiny")
    return folder, Block(folder, engine=False)


# --- The block ------------------------------------------------------------------------------------


def test_the_list_of_a_block_is_that_of_the_rtl(core):
    rtl = [Path(word).name for word in (ROOT / "rtl/ti.f").read_text().split()][1:]
    first = ["+incdir+src", "src/ti_config_pkg.sv", "src/ti_count_pkg.sv"]
    assert sources(core[0]) == [*first, *(f"src/{name}" for name in rtl), "ti_top_wrapper.v"]


def test_the_engine_has_one_clock(whole):
    assert whole[1].clocks_of_engine() == {"clk_i"}


def test_plain_verilog_is_verilog_with_the_same_registers(own, tmp_path):
    plain_verilog.write(make_ip(tmp_path, "tiny", "stream_clock=own"))
    text = (tmp_path / "ti_top_wrapper_plain.v").read_text()
    tree = pyslang.syntax.SyntaxTree.fromText(f'`begin_keywords "1364-2001"\n{text}')
    assert [d for d in tree.diagnostics if d.isError()] == []
    for crossing in own[1].crossings():
        register = re.split(r"[.\[]", crossing.end.rpartition("u_")[2])[1]
        assert re.search(rf"^  reg (\[\d+:0\] )?{register};", text, re.M)
    assert text.count("SYNCHRONIZER_IDENTIFICATION FORCED") == 5  # of one stream


def test_one_clock_is_crossed_nowhere(core):
    assert core[1].crossings() == []


def test_synchronisers_are_marked_in_the_rtl(own):
    modules = json.loads((own[0] / "hierarchy.json").read_text())["modules"]
    marked = [m for name, m in modules.items() if name.startswith("ti_sync")]
    assert len(marked) == 10
    for module in marked:
        attributes = module["netnames"]["stage_q"]["attributes"]
        assert attributes["ASYNC_REG"] == "TRUE"
        assert "SYNCHRONIZER_IDENTIFICATION FORCED" in attributes["altera_attribute"]


# --- Constraints ----------------------------------------------------------------------------------


def files_of(board, tool):
    """Constraints of a board's folder and the common ones, as its build script reads them."""
    folder = CONSTRAINTS / board
    clock = folder / ("clock.xdc" if tool == "vivado" else "clock.sdc")
    ports, crossings = (COMMON / f"{tool}_{name}.{SUFFIX[tool]}" for name in ("ports", "crossings"))
    more = [
        f for f in (folder / n for n in ("pins.xdc", "pins.tcl", "floorplan.tcl")) if f.exists()
    ]
    return [clock, ports, crossings, *more]


def test_each_folder_is_known_here_and_has_a_page():
    folders = {file.parent.name for file in CONSTRAINTS.glob("*/README.md")}
    assert folders == {board for boards in BOARDS.values() for board in boards}
    tools = {"vivado", "quartus", "common"}
    assert {f.name for f in CONSTRAINTS.iterdir() if f.is_dir()} == folders | tools


def pairs(tcl, records):
    """Registers between which a command bounds paths: {command: [{(from, to)}]}."""
    found = {}
    for record in records:
        starts = {tcl.register_of.get(cell) for cell in values(record, "-from")} - {None}
        ends = {tcl.register_of.get(c.removesuffix("/CLR")) for c in values(record, "-to")} - {None}
        if record[0].startswith("set_") and ends:
            between = {(start, end) for start in starts or {"aresetn"} for end in ends}
            found.setdefault(record[0], []).append(between)
    return found


def constrain(block, tool, board, folder):
    """(what is wrong with the constraints of a board, registers between which each has a bound)."""
    tcl = Tcl(block, tool)
    records, error = tcl.constraints(folder, *files_of(board, tool))
    found = pairs(tcl, records)
    wrong = [error] if error else []
    clocks = {record[-1] for record in records if record[0] == "create_clock"}
    wrong += [f"{c} has no clock" for c in block.clocks() - clocks]
    delayed = [
        w for r in records if r[0] in ("set_input_delay", "set_output_delay") for w in names(r[-1])
    ]
    bits = {
        f"{n}[{i}]" if size > 1 else n for n, size in block.ports().items() for i in range(size)
    }
    if sorted(delayed) != sorted(bits - block.clocks()):
        wrong.append("not each port has one delay")
    bound = set().union(*found.get("set_max_delay", []), *found.get("set_false_path", []))
    wrong += [f"{c} has no bound" for c in block.crossings() if (c.start, c.end) not in bound]
    return wrong, found


@pytest.mark.parametrize("clock", ["own", "core"])
@pytest.mark.parametrize(
    ("tool", "board"), [(t, b) for t in ("vivado", "quartus") for b in BOARDS[t]]
)
def test_all_names_of_constraints_are_in_the_design(tool, board, clock, request, tmp_path):
    _, block = request.getfixturevalue(clock)
    assert constrain(block, tool, board, tmp_path)[0] == []


@pytest.mark.parametrize("board", BOARDS["open"])
def test_all_names_of_open_tools_are_in_the_design(board, core):
    text = (CONSTRAINTS / board / f"{board}.lpf").read_text()
    names = re.findall(r'^(?:LOCATE COMP|IOBUF PORT|FREQUENCY PORT) "(.+?)"', text, re.MULTILINE)
    assert sorted(names) == ["aclk"] * 3 + ["aresetn"] * 2 + ["irq"] * 2
    assert set(names) <= set(core[1].ports())


@pytest.mark.parametrize(
    ("tool", "board", "skew"),
    [("vivado", "kv260", "set_bus_skew"), ("quartus", "de10_nano", "set_max_skew")],
)
def test_constraints_cover_exactly_the_crossings_there_are(tool, board, skew, own, tmp_path):
    crossings = {(c.start, c.end) for c in own[1].crossings()}
    assert len(crossings) == 20  # 2 of a reset, 4 of pointers, 4 of entries in halves, each stream
    wrong, found = constrain(own[1], tool, board, tmp_path)
    assert wrong == []
    bounds = found["set_max_delay"] + found["set_false_path"]
    for bound in bounds:
        assert bound & crossings, "names no crossing"
    resets = {pair for pair in crossings if pair[0] == "aresetn"}
    assert set.union(*found["set_false_path"]) == resets
    # Each word of Gray code is held together alone.
    gray = {pair for pair in crossings if pair[0].endswith("gray_q")}
    assert len(found[skew]) == len(gray)
    assert {pair for bound in found[skew] for pair in bound & crossings} == gray


def test_a_crossing_is_bound_by_the_faster_clock(own, tmp_path):
    clock = tmp_path / "clock.xdc"
    clock.write_text(
        "create_clock -name aclk -period 5.0 [get_ports aclk]\n"
        "create_clock -name axis00_aclk -period 3.0 [get_ports axis00_aclk]\n"
        "create_clock -name axis01_aclk -period 8.0 [get_ports axis01_aclk]\n"
    )
    common = [COMMON / "vivado_ports.tcl", COMMON / "vivado_crossings.tcl"]
    records, error = Tcl(own[1], "vivado").constraints(tmp_path, clock, *common)
    assert error == ""
    assert sum(record[0] == "create_clock" for record in records) == 3
    for record in records:
        if record[0] == "set_max_delay":
            assert record[2] == ("3.0" if "gen_stream[0]" in record[-1] else "5.0")


RENAMED = {
    "the port aclk": ("ti_top_wrapper.v", "aclk", "clk"),
    "the clock of a stream": ("ti_top_wrapper.v", "axis00_aclk", "axis00_clock"),
    "a pointer": ("src/ti_cdc_write.sv", "gray_q", "code_q"),
    "a synchroniser": ("src/ti_sync.sv", "stage_q", "row_q"),
    "the entries": ("src/ti_cdc_fifo.sv", "mem_q", "entries_q"),
    "a queue": ("src/ti_top.sv", "u_in", "u_queue"),
}


@pytest.mark.parametrize("what", RENAMED)
def test_a_new_name_turns_the_check_red(what, own, tmp_path):
    folder = shutil.copytree(own[0], tmp_path / "ip")
    file, old, new = RENAMED[what]
    text = (folder / file).read_text()
    assert re.search(rf"\b{old}\b", text)
    # In the wrapper a port is renamed, not the port of what is inside.
    (folder / file).write_text(re.sub(rf"(?<![.\w]){old}\b", new, text))
    xml = folder / "component.xml"
    xml.write_text(re.sub(rf">{old}<", f">{new}<", xml.read_text()))
    block = Block(folder, engine=False)
    for tool, board in (("vivado", "arty_a7_100t"), ("quartus", "de10_nano")):
        assert constrain(block, tool, board, tmp_path)[0] != []


# --- Build scripts --------------------------------------------------------------------------------


def build(tcl, tool, folder, tmp_path, *words):
    """Records of a build script, and its summary."""
    script = CONSTRAINTS / tool / "build.tcl"
    words = [f"folder={folder}", f"out={tmp_path / 'out'}", *words]
    records, error = tcl.run(tmp_path, f"source {{{script}}}", *words)
    assert error == ""
    return records, json.loads((tmp_path / "out/summary.json").read_text())


def of(records, command):
    return [record[1:] for record in records if record[0] == command]


@pytest.mark.parametrize("board", BOARDS["vivado"])
def test_vivado_reads_all_in_order_and_reports(board, own, tmp_path):
    folder, block = own
    records, summary = build(Tcl(block, "vivado"), "vivado", folder, tmp_path, f"board={board}")
    part = re.search(r"set part (\S+)", (CONSTRAINTS / board / "board.tcl").read_text())[1]
    files = [str(folder / name) for name in sources(folder)[1:]]
    assert of(records, "read_verilog") == [*(["-sv", f] for f in files[:-1]), files[-1:]]
    (synth,) = of(records, "synth_design")
    assert synth == [
        *("-top", "ti_top_wrapper", "-part", part, "-mode", "out_of_context"),
        *("-include_dirs", str(folder / "src"), "-verilog_define", "SYNTHESIS"),
    ]
    read = [Path(words[-1]).name for words in of(records, "read_xdc")]
    floorplan = ["floorplan.tcl"] if board == "alveo_u55c" else []
    assert read == ["clock.xdc", "vivado_ports.tcl", "vivado_crossings.tcl", *floorplan]
    assert all("-unmanaged" in w for w in of(records, "read_xdc") if w[-1].endswith(".tcl"))
    commands = [record[0] for record in records]
    order = ["synth_design", "opt_design", "place_design", "phys_opt_design", "route_design"]
    assert [command for command in commands if command in order] == order
    after = commands[commands.index("route_design") :]
    reports = {c for c in after if c.startswith("report_")}
    assert {f"report_{w}" for w in ("timing", "utilization", "cdc", "methodology")} <= reports
    period = float(re.search(r"-period (\S+)", (CONSTRAINTS / board / "clock.xdc").read_text())[1])
    assert (summary["part"], summary["setup_slack_ns"]) == (part, 1.0)
    assert summary["mhz"] == pytest.approx(1000 / (period - 1), abs=0.1)
    counts = {"lut": 1234, "lut_ram": 56, "ff": 2345, "bram": 10.5, "uram": 0, "dsp": 4}
    assert {key: summary[key] for key in counts} == counts


def test_cores_of_the_largest_part_lie_in_one_die_each(whole, tmp_path):
    folder, block = whole
    records, _ = build(Tcl(block, "vivado"), "vivado", folder, tmp_path, "board=alveo_u55c")
    cores = {words[0]: words[1] for words in of(records, "add_cells_to_pblock")}
    assert list(cores) == ["ti_SLR0", "ti_SLR1"]
    assert all(f"gen_core[{i}].u_core" in cells for i, cells in enumerate(cores.values()))


def test_quartus_reads_all_in_order_and_reports(own, tmp_path):
    folder, block = own
    (folder / "ti_top_wrapper_plain.f").write_text("ti_top_wrapper_plain.v\n")
    records, summary = build(Tcl(block, "quartus"), "quartus", folder, tmp_path, "board=de10_nano")
    assignments = [words[1:] for words in of(records, "set_global_assignment")]
    plain = str(folder / "ti_top_wrapper_plain.v")
    kinds = ["SYSTEMVERILOG_FILE", "VERILOG_FILE"]
    assert [words[1] for words in assignments if words[0] in kinds] == [plain]
    assert ["VERILOG_MACRO", "SYNTHESIS=1"] in assignments
    assert ["DEVICE", "5CSEBA6U23I7"] in assignments
    assert ["TOP_LEVEL_ENTITY", "ti_top_wrapper"] in assignments
    read = [Path(words[1]).name for words in assignments if words[0] == "SDC_FILE"]
    assert read == ["clock.sdc", "quartus_ports.sdc", "quartus_crossings.sdc"]
    commands = [record[0] for record in records]
    assert commands.index("export_assignments") < commands.index("execute_flow")
    assert of(records, "execute_flow") == [["-compile"]]
    counts = {"mhz": 61.25, "alm": 12345, "ff": 23456, "ram_bits": 1024, "ram_blocks": 7, "dsp": 8}
    assert {key: summary[key] for key in counts} == counts


@pytest.mark.parametrize(("tool", "board"), [("vivado", "arty_a7_100t"), ("quartus", "de10_nano")])
def test_a_top_of_the_board_gets_its_pins(tool, board, core, tmp_path):
    folder, block = core
    (folder / "ti_top_wrapper_plain.f").write_text("ti_top_wrapper_plain.v\n")
    words = [f"board={board}", "mode=full", "top=my_top", f"sources={tmp_path / 'my_top.sv'}"]
    records, summary = build(Tcl(block, tool), tool, folder, tmp_path, *words)
    assert summary["top"] == "my_top"
    if tool == "vivado":
        assert of(records, "read_verilog")[-1] == ["-sv", str(tmp_path / "my_top.sv")]
        read = [Path(words[-1]).name for words in of(records, "read_xdc")]
        assert read == ["clock.xdc", "pins.xdc", "vivado_crossings.tcl"]
        assert "out_of_context" not in of(records, "synth_design")[0]
    else:
        pins = {words[-1]: words[0] for words in of(records, "set_location_assignment")}
        assert pins == {"aclk": "PIN_V11", "aresetn": "PIN_AH17", "irq": "PIN_W15"}


@pytest.mark.parametrize(
    ("tool", "words", "message"),
    [
        ("vivado", ["board=de10_nano"], "this board is for quartus, not vivado"),
        ("vivado", ["board=none"], "none: no such board; there are alveo_u55c arty_a7_100t"),
        ("vivado", ["board=kv260", "mode=full"], "mode=full needs top="),
        ("quartus", [], "board= is missing"),
        ("quartus", ["board=de10_nano", "speed=1"], "'speed=1' is no argument"),
    ],
)
def test_bad_arguments_are_told(tool, words, message, core, tmp_path):
    script = CONSTRAINTS / tool / "build.tcl"
    words = [f"folder={core[0]}", f"out={tmp_path}", *words]
    records, error = Tcl(core[1], tool).run(tmp_path, f"source {{{script}}}", *words)
    assert message in error and records == []


PROGRAMS = {"vivado": "vivado", "quartus": "quartus_sh"}


@pytest.mark.parametrize("tool", PROGRAMS)
def test_a_tool_that_is_missing_is_told_in_a_sentence(tool):
    command, path = [ROOT / "scripts/vendor.sh", tool], {"PATH": "/usr/bin:/bin"}
    done = subprocess.run(command, env=path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert f"{PROGRAMS[tool]} is not on PATH" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("tool", PROGRAMS)
def test_a_tool_that_is_there_gets_script_and_arguments(tool, tmp_path):
    program = tmp_path / PROGRAMS[tool]
    program.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    program.chmod(0o755)
    command = [ROOT / "scripts/vendor.sh", tool, "folder=a b", "board=c"]
    path = {"PATH": f"{tmp_path}:/usr/bin:/bin"}
    done = subprocess.run(command, env=path, capture_output=True, text=True, check=True)
    words = done.stdout.splitlines()
    assert f"constraints/{tool}/build.tcl" in words and words[-2:] == ["folder=a b", "board=c"]
