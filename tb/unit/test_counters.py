# SPDX-License-Identifier: Apache-2.0
"""`scripts/counters.py`: package, C++ header and the table of docs/counters.md say the same."""

import re
import subprocess
import sys
from pathlib import Path

import configure
import counters
import pytest
import yaml
from models.payload import Payloads

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/counters.py"
TABLE = ROOT / "docs/counters.md"
UNITS = list(counters.description()["units"])
KINDS = counters.kinds(counters.description())  # of units, each with its unit of the table
CONFIGS = ["tiny", "small", "paper", "tiny list_l2_bytes=2048 list_l2_banks=2"]


def config_of(name):
    name, *overrides = name.split()
    return configure.load(name, overrides).values


def rows():
    """(kinds of units, number, name, meaning) of each line of the table."""
    line = re.compile(r"\| (every|`\w+`(?:, `\w+`)*) \| (\d+) \| `(\w+)` \| (.*) \|")
    return [
        (re.findall(r"\w+", m[1]), int(m[2]), m[3], m[4]) for m in line.finditer(TABLE.read_text())
    ]


def units_of(config, kind):
    """How many units of a kind there are; the banks of an L2 where there is one."""
    if kind.endswith("_l2"):
        return config[f"{kind}_banks"] if config[f"{kind}_bytes"] else 0
    return config.get(f"num_{kind}", 1)


def script(*arguments):
    return subprocess.run(
        [sys.executable, str(SCRIPT), *map(str, arguments)], capture_output=True, text=True
    )


@pytest.mark.parametrize("unit", UNITS)
def test_bit_i_of_the_struct_is_event_i(unit):
    names = Payloads(config_of("tiny")).names(f"{unit}_events_t")

    assert names == list(counters.events(counters.description(), unit))


@pytest.mark.parametrize("unit", KINDS)
def test_the_table_has_the_numbers_and_names_of_the_package(unit):
    names = Payloads(config_of("tiny")).names(f"{KINDS[unit]}_events_t")
    table = {number: name for owners, number, name, _ in rows() if {"every", unit} & {*owners}}

    assert [table[i] for i in range(len(table))] == names


def test_every_event_of_the_source_is_explained_in_the_table():
    source = yaml.safe_load((ROOT / "rtl/count/counters.yaml").read_text())
    texts = [(name, text) for _, _, name, text in rows()]

    for group in (source["activity"], source["cache"], *source["units"].values()):
        for name, text in group.items():
            assert name in ("cache", "of") or (name, text) in texts


@pytest.mark.parametrize("name", CONFIGS)
def test_package_and_header_agree(name):
    config = config_of(name)
    package, header = counters.package(config), counters.header(config)
    entry = re.compile(r'\{"(\w+)", (\d+), (\d+), \{(.*?)\}\}')
    entries = {m[1]: (int(m[2]), int(m[3]), m[4]) for m in entry.finditer(header)}
    first = 0

    assert list(entries) == list(KINDS)
    for unit, (number, count, names) in entries.items():
        names = re.findall(r'"(\w+)"', names)
        assert names == list(counters.events(counters.description(), KINDS[unit]))
        assert f"Unit{counters.camel(unit)} = {number};" in package
        assert f"Num{counters.camel(KINDS[unit])}Events = {len(names)};" in package
        assert number == first and count == units_of(config, unit)
        first += count
    assert f"NumUnits = {first};" in package
    banks = sum(entries[kind][1] for kind in ("trv_l2", "list_l2", "ist1_l2"))
    assert list(entries)[-1] == "axi" and entries["axi"][0] == entries["trv_l2"][0] + banks
    assert f"kActivities = {len(counters.description()['activity'])};" in header


@pytest.mark.parametrize("name", CONFIGS)
def test_the_indices_are_wide_enough(name):
    payloads = Payloads(config_of(name))
    widest = max(len(counters.events(counters.description(), unit)) for unit in UNITS)
    units = sum(counters.counts_of(config_of(name)).values())

    assert 1 << payloads.width("event_index_t") >= widest
    assert 1 << payloads.width("unit_index_t") >= units
    assert payloads.width("count_t") == 48


def test_the_page_has_the_table_of_the_source():
    assert script("--check", TABLE).returncode == 0


def test_another_table_is_told_and_mended(tmp_path):
    page = tmp_path / "counters.md"
    page.write_text(TABLE.read_text().replace("`rays`", "`beams`"))
    told = script("--check", page)
    assert told.returncode == 1 and "run scripts/counters.py --write" in told.stdout

    assert script("--write", page).returncode == 0
    assert page.read_text() == TABLE.read_text()
    assert script("--check", page).returncode == 0
