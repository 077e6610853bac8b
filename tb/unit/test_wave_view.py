# SPDX-License-Identifier: Apache-2.0
"""`scripts/wave_view.py` groups the ports of a unit by stream, shows binary32 as numbers."""

import gzip

import pytest
import wave_view
from agents.bench import RTL
from configure import configure
from wave_view import Variable

UNITS = sorted(p.stem for p in RTL.rglob("*.sv") if not p.stem.endswith("_pkg"))


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    folder = tmp_path_factory.mktemp("config")
    configure("tiny", [], folder)
    return folder


def grouped(ports):
    return {group.name: group.ports for group in wave_view.groups(ports)}


def test_streams_of_ra_are_groups(config):
    assert grouped(wave_view.read_unit("ti_ra", config).ports) == {
        "clock and reset": ["clk_i", "rst_ni"],
        "req (in)": ["req_valid_i", "req_ready_o", "req_slot_i", "req_addr_i"],
        "rsp (out)": ["rsp_valid_o", "rsp_ready_i", "rsp_slot_o", "rsp_elem_o", "rsp_error_o"],
        "line_req (out)": ["line_req_valid_o", "line_req_ready_i", "line_req_data_o"],
        "line_rsp (in)": ["line_rsp_valid_i", "line_rsp_ready_o", "line_rsp_data_i"],
        "other ports": ["flush_i", "idle_o", "waits_o", "events_o"],
    }


def test_operands_and_result_of_an_operator_are_groups(config):
    unit = wave_view.read_unit("ti_fp_add", config)
    assert grouped(unit.ports) == {
        "clock and reset": ["clk_i", "rst_ni"],
        "in": ["valid_i", "a_i", "b_i", "negate_b_i"],
        "out": ["valid_o", "result_o"],
    }
    assert unit.floats >= {"a_i", "b_i", "result_o"}
    assert "negate_b_i" not in unit.floats


def test_channels_of_axi_are_groups(config):
    found = grouped(wave_view.read_unit("ti_engine", config).ports)
    assert found["m_axi_ar (AXI)"][:3] == ["m_axi_arvalid", "m_axi_arready", "m_axi_arid"]
    assert found["m_axi_r (AXI)"][:3] == ["m_axi_rvalid", "m_axi_rready", "m_axi_rid"]


@pytest.mark.parametrize("name", UNITS)
def test_each_port_is_in_one_group(config, name):
    ports = wave_view.read_unit(name, config).ports
    shown = [port for group in wave_view.groups(ports) for port in group.ports]
    assert sorted(shown) == sorted(ports)


def test_floats_in_structs_and_arrays_are_known(config):
    floats = wave_view.read_unit("ti_ist2", config).floats
    assert {"return_data_o.t", "return_data_o.u", "return_data_o.v"} <= floats
    assert "return_data_o.prim" not in floats


def dump_of(paths):
    return [Variable(path, bits, False) for path, bits in paths]


def test_only_binary32_is_shown_as_numbers():
    unit = wave_view.Unit(["clk_i", "valid_i", "a_i"], {"a_i", "ring_q"})
    wide = dump_of([("ti_x.clk_i", 1), ("ti_x.a_i[31:0]", 32), ("ti_x.ring_q.ring_q[1][31:0]", 32)])
    text = wave_view.gtkwave("ti_x", unit, wide)
    assert "@28\nti_x.clk_i\n" in text
    assert "@40020\nti_x.a_i[31:0]\n" in text
    assert "@40020\nti_x.ring_q.ring_q[1][31:0]\n" in text
    narrow = dump_of([("ti_x.a_i[23:0]", 24)])
    assert "@22\nti_x.a_i[23:0]\n" in wave_view.gtkwave("ti_x", unit, narrow)


def test_enums_are_shown_by_name():
    unit = wave_view.Unit(["clk_i"], set())
    text = wave_view.gtkwave("ti_x", unit, [Variable("ti_x.state_q[1:0]", 2, True)])
    assert "@100000028\nti_x.state_q[1:0]\n" in text


def test_a_field_keeps_the_name_of_its_struct():
    unit = wave_view.Unit(["data_i"], set())
    text = wave_view.gtkwave("ti_x", unit, dump_of([("ti_x.data_i.line[7:0]", 8)]))
    assert "+{data_i/line[7:0]} ti_x.data_i.line[7:0]" in text


def test_a_unit_of_wires_shows_the_registers_inside():
    unit = wave_view.Unit(["clk_i"], set())
    dump = dump_of([("ti_x.clk_i", 1), ("ti_x.u_fifo.count_q[3:0]", 4), ("ti_x.u_fifo.full", 1)])
    text = wave_view.gtkwave("ti_x", unit, dump)
    assert "+{u_fifo/count_q[3:0]} ti_x.u_fifo.count_q[3:0]" in text
    assert "full" not in text


def test_surfer_gets_the_same_rows():
    unit = wave_view.Unit(["clk_i", "in_valid_i"], set())
    dump = dump_of([("ti_x.clk_i", 1), ("ti_x.in_valid_i", 1), ("ti_x.count_q[3:0]", 4)])
    assert wave_view.surfer("ti_x", unit, dump).splitlines() == [
        "divider_add clock_and_reset",
        "variable_add ti_x.clk_i",
        "divider_add in",
        "variable_add ti_x.in_valid_i",
        "divider_add state",
        "variable_add ti_x.count_q",
        "zoom_fit",
    ]


# A unit with a bit, a vector of one bit, and an enum of two bits.
HIERARCHY = (
    b"\xfe\x00ti_x\x00\x00"  # scope
    b"\x10\x01clk_i\x00\x01\x00"
    b"\x10\x01way_q [0:0]\x00\x01\x00"
    b"\xfc\x00\x07\x00\x01"  # the next one is of the first enum
    b"\x10\x01state_q [1:0]\x00\x02\x00"
    b"\xff"
)
INSIDE = [
    Variable("ti_x.clk_i", 1, False),
    Variable("ti_x.way_q[0]", 1, False),
    Variable("ti_x.state_q[1:0]", 2, True),
]


def literals(data):
    """`data` as an LZ4 block without copies."""
    rest = len(data) - 15
    return bytes([0xF0, *[255] * (rest // 255), rest % 255]) + data


def block(kind, content):
    return bytes([kind]) + (len(content) + 8).to_bytes(8, "big") + content


@pytest.mark.parametrize("kind", [wave_view.GZIP, wave_view.LZ4, wave_view.LZ4_TWICE])
def test_the_names_in_a_dump_are_read(tmp_path, kind):
    size = len(HIERARCHY).to_bytes(8, "big")
    packed = literals(HIERARCHY)
    content = {
        wave_view.GZIP: size + gzip.compress(HIERARCHY),
        wave_view.LZ4: size + packed,
        wave_view.LZ4_TWICE: size + len(packed).to_bytes(8, "big") + literals(packed),
    }[kind]
    dump = tmp_path / "dump.fst"
    dump.write_bytes(block(0, bytes(321)) + block(kind, content))
    assert wave_view.read_dump(dump) == INSIDE


def test_a_dump_that_ended_early_is_told(tmp_path):
    dump = tmp_path / "dump.fst"
    dump.write_bytes(block(0, bytes(321)))
    with pytest.raises(wave_view.ViewError, match="no list of variables"):
        wave_view.read_dump(dump)


def test_lz4_copies_may_overlap_themselves():
    # "ab", then 7 bytes from 2 back, then "!".
    assert wave_view.unpack_lz4(b"\x23ab\x02\x00\x10!", 10) == b"ababababa!"
