# SPDX-License-Identifier: Apache-2.0
"""A parameter that a module cannot have stops its elaboration with the module's own sentence."""

import re
import subprocess

import pytest
from agents.bench import BUILD, ROOT, RTL, packages
from configure import configure

FOLDERS = ("common", "fp", "mem", "count")

# Module, parameters, its sentence; with a module's name in front, that of a module inside.
BAD = [
    ("ti_arbiter", {"NumIn": 0}, "NumIn must be 1 or more"),
    ("ti_fifo", {"Depth": 0}, "Depth must be 1 or more"),
    ("ti_cdc_fifo", {"Depth": 0}, "Depth must be a power of two from 2"),
    ("ti_cdc_fifo", {"Depth": 1}, "Depth must be a power of two from 2"),
    ("ti_cdc_fifo", {"Depth": 12}, "Depth must be a power of two from 2"),
    ("ti_cdc_fifo", {"SyncStages": 1}, "ti_sync: Stages must be 2 or more"),
    ("ti_cdc_write", {"Depth": 12}, "Depth must be a power of two from 2"),
    ("ti_cdc_write", {"SyncStages": 1}, "ti_sync: Stages must be 2 or more"),
    ("ti_cdc_read", {"Depth": 12}, "Depth must be a power of two from 2"),
    ("ti_cdc_read", {"SyncStages": 1}, "ti_sync: Stages must be 2 or more"),
    ("ti_sync", {"Width": 0}, "Width must be 1 or more"),
    ("ti_sync", {"Stages": 1}, "Stages must be 2 or more"),
    ("ti_queue", {"Depth": 0}, "Depth must be 1 or more"),
    ("ti_ram_1r1w", {"Depth": 0}, "Depth must be 1 or more"),
    *(("ti_regfile", {key: 0}, "Depth and RamBits must be 1") for key in ("Depth", "RamBits")),
    ("ti_round_robin", {"Num": 0}, "Num must be 1 or more"),
    ("ti_slot_pool", {"NumSlots": 1}, "NumSlots must be 2 or more"),
    ("ti_credits", {"Num": 0}, "Num must be 1 or more"),
    ("ti_xbar", {"NumIn": 0}, "NumIn must be 1 or more"),
    ("ti_xbar", {"NumOut": 0}, "NumOut must be 1 or more"),
    *(
        (f"ti_fp_{unit}", {key: value}, f"{key} must be {most}.")
        for unit in ("add", "mul", "cmp", "rcp", "class")
        for key, value, most in [
            ("ExpBits", 2, "3 to 8"),
            ("ExpBits", 9, "3 to 8"),
            ("FracBits", 1, "2 to 23"),
            ("FracBits", 24, "2 to 23"),
        ]
    ),
    ("ti_fp_add", {"Stages": 3}, "Stages must be 4 to 10."),
    ("ti_fp_add", {"Stages": 11}, "Stages must be 4 to 10."),
    ("ti_fp_mul", {"Stages": 2}, "Stages must be 3 to 8."),
    ("ti_fp_mul", {"Stages": 9}, "Stages must be 3 to 8."),
    ("ti_fp_rcp", {"BitsPerStage": 0}, "BitsPerStage must be 1 to 3."),
    ("ti_fp_rcp", {"BitsPerStage": 4}, "BitsPerStage must be 1 to 3."),
    ("ti_fp_rcp", {"EndStages": 1}, "EndStages must be 2 to 5."),
    ("ti_fp_rcp", {"EndStages": 6}, "EndStages must be 2 to 5."),
    ("ti_fp_rcp", {"TableBits": 13}, "ti_fp_newton: TableBits must be 1 to 12 and at most Frac"),
    ("ti_fp_rcp", {"TableBits": 7, "NewtonSteps": 3}, "ti_fp_newton: Steps must be 0 to 2."),
    ("ti_fp_rcp", {"TableBits": 7, "ProductStages": 3}, "ti_fp_newton: ProductStages must be 1"),
    ("ti_fp_newton", {"FracBits": 6}, "TableBits must be 1 to 12 and at most FracBits."),
    ("ti_fp_newton", {"TableBits": 13}, "TableBits must be 1 to 12 and at most FracBits."),
    ("ti_fp_newton", {"Steps": 3}, "Steps must be 0 to 2."),
    ("ti_fp_newton", {"ProductStages": 3}, "ProductStages must be 1 or 2."),
    ("ti_l1", {"Ways": 0}, "Ways must be a power of two"),
    ("ti_l1", {"Ways": 3}, "Ways must be a power of two"),
    ("ti_l1", {"CacheBytes": 1000}, "CacheBytes must be Ways * LineBytes times a power of two"),
    ("ti_l1", {"CacheBytes": 384}, "CacheBytes must be Ways * LineBytes times a power of two"),
    ("ti_l1", {"CacheBytes": 64}, "CacheBytes must be Ways * LineBytes times a power of two"),
    ("ti_l1", {"LineAddrWidth": 3}, "LineAddrWidth must be more than the bits of the number of a"),
    ("ti_l1", {"LineBytes": 48}, "CacheBytes must be Ways * LineBytes times a power of two"),
    ("ti_ra", {"Ways": 0}, "ti_l1: Ways must be a power of two"),
    ("ti_ra", {"Ways": 3}, "ti_l1: Ways must be a power of two"),
    ("ti_ra", {"CacheBytes": 1000}, "ti_l1: CacheBytes must be Ways * LineBytes times a power of"),
    ("ti_ra", {"NumSlots": 1}, "NumSlots must be 2 or more"),
    ("ti_ra", {"Rows": 0}, "Rows must be 1 to ti_mem_pkg::MaxRows"),
    ("ti_ra", {"Rows": 3}, "Rows must be 1 to ti_mem_pkg::MaxRows"),
    ("ti_ra", {"LookupStages": 0}, "LookupStages must be 1 to 5"),
    ("ti_ra", {"LookupStages": 6}, "LookupStages must be 1 to 5"),
    ("ti_ra_rows", {"NumSlots": 1}, "NumSlots must be 2 or more, other sizes 1 or more"),
    *(
        ("ti_ra_rows", {key: 0}, "NumSlots must be 2 or more, other sizes 1 or more")
        for key in ("Rows", "Sets", "ElemWidth", "WayWidth")
    ),
    ("ti_ra_retry", {"NumSlots": 1}, "NumSlots must be 2 or more"),
    ("ti_ra_answers", {"SlotWidth": 0}, "SlotWidth must be 1 or more"),
    *(("ti_ra_answers", {"LookupStages": n}, "LookupStages must be 1 to 5") for n in (0, 6)),
    ("ti_ra_answers", {"ElemBytes": 24}, "ElemBytes must divide WordBytes into a power of two"),
    ("ti_ra_answers", {"WordBytes": 60}, "ElemBytes must divide WordBytes into a power of two"),
    ("ti_ra", {"FillBytes": 24}, "ti_l1: WordBytes must divide LineBytes into a power of two"),
    ("ti_ra_fill", {"LineBytes": 60}, "WordBytes must divide LineBytes into a power of two"),
    ("ti_ra_fill", {"WordBytes": 24}, "WordBytes must divide LineBytes into a power of two"),
    ("ti_ra_fill", {"WordBytes": 0}, "WordBytes must divide LineBytes into a power of two"),
    ("ti_l1", {"WordBytes": 24}, "WordBytes must divide LineBytes into a power of two"),
    ("ti_ra", {"ElemBytes": 24}, "ElemBytes must divide LineBytes into a power of two"),
    ("ti_ra", {"ElemBytes": 128}, "ElemBytes must divide LineBytes into a power of two"),
    *(
        ("ti_l2_bank", {key: 0}, "NumUnits and UnitIds must be 1 or more, UnitIds at most the ids")
        for key in ("NumUnits", "UnitIds")
    ),
    ("ti_l2_bank", {"UnitIds": 3}, "NumUnits and UnitIds must be 1 or more, UnitIds at most the"),
    ("ti_l2_bank", {"NumBanks": 0}, "NumBanks must be a power of two, less than the lines of"),
    ("ti_l2_bank", {"NumBanks": 3}, "NumBanks must be a power of two, less than the lines of"),
    ("ti_l2_bank", {"NumBanks": 1 << 26}, "NumBanks must be a power of two, less than the lines"),
    ("ti_l2_bank", {"Latency": 0}, "Latency must be LookupStages + 2 or"),
    ("ti_l2_bank", {"Latency": 2}, "Latency must be LookupStages + 2 or"),
    ("ti_l2_bank", {"Rows": 3}, "ti_ra: Rows must be 1 to ti_mem_pkg::MaxRows"),
    ("ti_l2_bank", {"Ways": 3}, "ti_l1: Ways must be a power of two"),
    ("ti_l2_bank", {"CacheBytes": 1000}, "ti_l1: CacheBytes must be Ways * LineBytes times a"),
    ("ti_l2", {"NumBanks": 0}, "NumBanks must be a power of two"),
    ("ti_l2", {"NumBanks": 3}, "NumBanks must be a power of two"),
    ("ti_l2", {"CacheBytes": 1023, "NumBanks": 2}, "CacheBytes must divide into NumBanks banks"),
    ("ti_l2", {"NumUnits": 0}, "NumUnits must be 1 or more"),
    ("ti_l2", {"UnitIds": 3}, "ti_l2_bank: NumUnits and UnitIds must be 1 or more, UnitIds at"),
    ("ti_l2", {"Latency": 0}, "Latency must be LookupStages + 3 or"),
    ("ti_l2", {"Latency": 3}, "Latency must be LookupStages + 3 or"),
    ("ti_l2", {"Rows": 0}, "ti_ra: Rows must be 1 to ti_mem_pkg::MaxRows"),
    ("ti_l2", {"Ways": 3}, "ti_l1: Ways must be a power of two"),
    ("ti_lines", {"NumUnits": 0}, "NumUnits must be 1 or more, and the last one a client of"),
    ("ti_lines", {"FirstClient": 3}, "NumUnits must be 1 or more, and the last one a client of"),
    ("ti_axi_read", {"MaxReads": 1}, "MaxReads must be a power of two from 2 to 1024"),
    ("ti_axi_read", {"MaxReads": 12}, "MaxReads must be a power of two from 2 to 1024"),
    ("ti_axi_read", {"MaxReads": 2048}, "MaxReads must be a power of two from 2 to 1024"),
    ("ti_read_timeout", {"Timeout": 0}, "Timeout must be 1 or more"),
    ("ti_read_timeout", {"NumReads": 3}, "NumReads must be a power of two, 2 or more"),
    ("ti_counters", {"Num": 0}, "Num must be 1 or more"),
    ("ti_rd_clip", {"RayCycles": 0}, "RayCycles must be 1 to 3"),
    ("ti_rd_clip", {"RayCycles": 4}, "RayCycles must be 1 to 3"),
    ("ti_rd", {"RayCycles": 0}, "ti_rd_clip: RayCycles must be 1 to 3"),
    ("ti_rd", {"RayCycles": 4}, "ti_rd_clip: RayCycles must be 1 to 3"),
]
# These take what they are given.
NO_BAD_VALUE = {("ti_delay", "Cycles"), ("ti_axi_read", "Timeout")}
# Sentences that no parameter brings about: the configuration or the source would have to be wrong.
OF_THE_SOURCE = ("Latency is not that of ti_fp_pkg.", "LineBytes must be 8 to 128")


def modules():
    return [path for folder in FOLDERS for path in sorted((RTL / folder).glob("ti_*.sv"))]


def parameters(path):
    """Names of the numeric parameters of a module."""
    return re.findall(r"^\s*parameter\s+int unsigned\s+(\w+)", path.read_text(), re.MULTILINE)


@pytest.fixture(scope="module")
def config():
    folder = BUILD / "unit/parameter_guards/config"
    configure("tiny", [], folder)
    return folder


def elaborate(module, values, config):
    return subprocess.run(
        [
            "verilator",
            "--lint-only",
            f"-I{config}",
            *(f"-I{RTL / folder}" for folder in (*FOLDERS, "traverse/common")),
            str(ROOT / "lint/verilator.vlt"),
            str(config / "ti_config_pkg.sv"),
            str(config / "ti_count_pkg.sv"),
            *map(str, packages()),
            *(f"-G{name}={value}" for name, value in values.items()),
            "--top-module",
            module,
            f"{module}.sv",
        ],
        capture_output=True,
        text=True,
    )


@pytest.mark.parametrize(
    ("module", "values", "sentence"),
    BAD,
    ids=[f"{m}-{'-'.join(f'{k}={v}' for k, v in values.items())}" for m, values, _ in BAD],
)
def test_a_bad_value_is_told_by_name(module, values, sentence, config):
    result = elaborate(module, values, config)

    assert result.returncode != 0
    wanted = sentence if sentence.startswith("ti_") else f"{module}: {sentence}"
    assert wanted in result.stderr, result.stderr


@pytest.mark.parametrize("module", sorted({module for module, _, _ in BAD}))
def test_the_defaults_elaborate(module, config):
    """So that it is the value that stops the others."""
    result = elaborate(module, {}, config)

    assert result.returncode == 0, result.stderr


def test_every_parameter_and_every_sentence_is_in_the_table():
    tried = {(module, name) for module, values, _ in BAD for name in values}
    there = {(path.stem, name) for path in modules() for name in parameters(path)}
    sentences = {
        (path.stem, sentence)
        for path in modules()
        for sentence in re.findall(rf'\$error\(\s*"{path.stem}: (.*?)"', path.read_text())
        if not sentence.startswith(OF_THE_SOURCE)
    }

    assert there - tried == NO_BAD_VALUE
    for module, sentence in sentences:
        assert any(module == m and sentence.startswith(s) for m, _, s in BAD), (module, sentence)
