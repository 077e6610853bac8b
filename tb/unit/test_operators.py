# SPDX-License-Identifier: Apache-2.0
"""`scripts/operators.py` counts what the elaborated engine has; one operator too many fails."""

import json
import re
import shutil
import subprocess
import sys

import pytest
from agents.bench import ROOT
from configure import configure


def count(folder, config, rtl=ROOT / "rtl"):
    """Run the script on a configuration; the finished process and the counts."""
    name, *overrides = config.split()
    configure(name, overrides, folder)
    command = [sys.executable, ROOT / "scripts/operators.py", folder, "--rtl", rtl]
    done = subprocess.run(
        [*command, "--json", folder / "out.json"], capture_output=True, text=True, check=False
    )
    out = folder / "out.json"
    return done, json.loads(out.read_text()) if out.is_file() else None


def edited(folder, file, old, new):
    """A copy of the RTL with one text replaced."""
    rtl = folder / "rtl"
    shutil.copytree(ROOT / "rtl", rtl)
    text = (rtl / file).read_text()
    assert text.count(old) == 1
    (rtl / file).write_text(text.replace(old, new))
    return rtl


@pytest.mark.parametrize(
    "config",
    [
        "paper",
        "tiny",
        "small num_trv=3",
        "watertight",
        "fpga",
        "tiny triangle_test=np rd_cycles=2",
    ],
)
def test_engine_is_within_the_published_budget(tmp_path, config):
    done, numbers = count(tmp_path, config)
    assert done.returncode == 0, done.stderr
    configuration = numbers["config"]
    for kind, key in [("TRV", "num_trv"), ("LIST", "num_list"), ("IST1", "num_ist1")]:
        assert numbers["kinds"][kind]["units"] == configuration[key]
    woop = configuration["triangle_test"] == "woop"
    ist2 = {"ADD": 4, "MUL": 7} if woop else {"ADD": 0, "MUL": 3}
    assert numbers["kinds"]["IST2"]["operators"] == {**ist2, "RCP": 1, "CMP": 0}
    ist1 = {"ADD": 18, "MUL": 12} if woop else {"ADD": 7, "MUL": 8}
    each = numbers["kinds"]["IST1"]["operators"]
    assert {k: each[k] / configuration["num_ist1"] for k in ist1} == ist1


@pytest.mark.parametrize("ray_cycles", [1, 2, 3])
def test_rd_has_a_lane_for_each_axis_that_another_cannot_take(tmp_path, ray_cycles):
    done, numbers = count(tmp_path, f"tiny rd_cycles={ray_cycles}")
    lanes = 4 - ray_cycles
    lane = {"ADD": 2 * lanes, "MUL": 2 * lanes, "RCP": lanes, "CMP": 2 * lanes + 2}
    assert done.returncode == 0, done.stderr
    assert numbers["kinds"]["RD"]["operators"] == lane
    assert numbers["kinds"]["RD"]["published"] == {"ADD": 6, "MUL": 9, "RCP": 1, "CMP": 12}


@pytest.mark.parametrize("ray_cycles", [1, 3])
def test_a_reciprocal_more_than_lanes_fails(tmp_path, ray_cycles):
    end = "endmodule : ti_rd_clip"
    rtl = edited(tmp_path, "traverse/common/ti_rd_clip.sv", end, EXTRA_RCP + end)
    done, _ = count(tmp_path, f"tiny rd_cycles={ray_cycles}", rtl)
    assert done.returncode == 1
    assert f"{5 - ray_cycles} RCP" in done.stderr and "RD" in done.stderr


def test_l2_lines_of_paper_stand_beside_the_published(tmp_path):
    done, numbers = count(tmp_path, "paper")
    assert numbers["total"]["bits"]["l2_lines"] == 288 * 8192
    assert re.search(r"^l2_lines +288\.0 +288 L2$", done.stdout, re.MULTILINE), done.stdout


def test_budget_of_paper_is_the_published_total(tmp_path):
    _, numbers = count(tmp_path, "paper")
    assert numbers["total"]["published"] == {"ADD": 86, "MUL": 92, "RCP": 2, "CMP": 108}


READERS = ("trv", "list", "ist1")


def tags_of(keys, cache, banks=1):
    """Bits of tags and state of one cache, over its banks, with those of the set looked up.

    A use and an arrived line are on their way to the state in registers: two flags, set and way,
    and the tree after a use.
    """
    size, ways = keys[f"{cache}_bytes"] // banks, keys[f"{cache}_ways"]
    sets = size // (ways * keys["line_bytes"])
    tag = keys["addr_bits"] - (keys["line_bytes"] - 1).bit_length() - (sets - 1).bit_length()
    tree = max(ways - 1, 1)
    state = (sets + 1) * (2 * ways + tree)
    place = max((sets - 1).bit_length(), 1) + max((ways - 1).bit_length(), 1)
    return banks * (ways * tag * (max(sets, 2) + 1) + 1 + state + 2 * (2 + place) + tree)


@pytest.mark.parametrize("config", ["paper", "tiny", "tiny ist1_l2_bytes=8192 ist1_l2_banks=2"])
def test_memory_is_what_the_configuration_asks_for(tmp_path, config):
    _, numbers = count(tmp_path, config)
    keys, bits = numbers["config"], numbers["total"]["bits"]
    assert bits["l1_lines"] == sum(8 * keys[f"num_{u}"] * keys[f"{u}_l1_bytes"] for u in READERS)
    assert bits["l2_lines"] == sum(8 * keys[f"{u}_l2_bytes"] for u in READERS)
    assert numbers["kinds"]["between"]["bits"]["l2_lines"] == bits["l2_lines"]
    assert bits["l1_tags"] == sum(keys[f"num_{u}"] * tags_of(keys, f"{u}_l1") for u in READERS)
    assert bits["l2_tags"] == sum(
        tags_of(keys, f"{u}_l2", keys[f"{u}_l2_banks"]) for u in READERS if keys[f"{u}_l2_bytes"]
    )
    # A leaf in a LIST slot: TRV and slot of its home, origin, direction and interval.
    home = max(1, (keys["num_trv"] - 1).bit_length()) + (keys["trv_slots"] - 1).bit_length()
    slot = home + 8 * (1 + keys["exp_bits"] + keys["frac_bits"])
    assert numbers["kinds"]["LIST"]["bits"]["slots"] == keys["num_list"] * keys["list_slots"] * slot


EXTRA_CMP = """\
  ti_fp_cmp #(.ExpBits(ti_num_pkg::ExpBits), .FracBits(ti_num_pkg::FracBits)) u_extra (
    .a_i('0), .b_i('0), .lt_o(), .eq_o(), .le_o(), .unordered_o()
  );
"""

EXTRA_RCP = """\
  ti_fp_rcp #(.ExpBits(ti_num_pkg::ExpBits), .FracBits(ti_num_pkg::FracBits)) u_extra (
    .clk_i, .rst_ni, .valid_i(1'b0), .a_i('0), .valid_o(), .result_o()
  );
"""


@pytest.mark.parametrize(
    "module, kind",
    [
        ("traverse/kd/ti_kd_decide", "TRV"),
        ("intersect/ti_list", "LIST"),
        ("top/ti_core", "between"),
    ],
)
def test_operator_above_the_budget_fails(tmp_path, module, kind):
    end = f"endmodule : {module.rpartition('/')[2]}"
    done, _ = count(tmp_path, "tiny", edited(tmp_path, f"{module}.sv", end, EXTRA_CMP + end))
    assert done.returncode == 1
    assert "CMP" in done.stderr and kind in done.stderr


def test_operators_under_a_false_generate_do_not_count(tmp_path):
    end = "endmodule : ti_kd_decide"
    never = f"if (StackDepth == 0) begin : gen_never\n{EXTRA_CMP}end\n"
    rtl = edited(tmp_path, "traverse/kd/ti_kd_decide.sv", end, never + end)
    done, _ = count(tmp_path, "tiny", rtl)
    assert done.returncode == 0, done.stderr


def test_unreadable_design_is_named(tmp_path):
    rtl = edited(tmp_path, "traverse/kd/ti_kd_decide.sv", "endmodule : ti_kd_decide", "assign")
    done, _ = count(tmp_path, "tiny", rtl)
    assert done.returncode == 2
    assert "ti_kd_decide.sv" in done.stdout + done.stderr
