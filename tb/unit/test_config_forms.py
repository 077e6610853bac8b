# SPDX-License-Identifier: Apache-2.0
"""A configuration has one set of values in all its forms, and the page has the table of keys."""

import json
import re

import configure
import pytest
import yaml
from agents.configure_script import DOCUMENT, FORMS, ROOT, SCHEMA, complaints, script

CONFIGS = sorted(path.stem for path in (ROOT / "configs").glob("*.yaml") if path.stem != "schema")


def camel(key):
    return key.title().replace("_", "")


def in_sv(key, value):
    """A value in SystemVerilog, without a prefix of its width."""
    return camel(f"{key}_{value}") if SCHEMA.keys[key].kind == "enum" else str(int(value))


def in_cpp(key, value):
    """A value in C++."""
    enum = SCHEMA.keys[key].kind == "enum"
    return f"{camel(key)}::k{camel(value)}" if enum else json.dumps(value)


@pytest.mark.parametrize("name", CONFIGS)
def test_every_form_has_the_values_of_the_yaml(name, tmp_path):
    assert script(name, "--out", tmp_path).returncode == 0
    stored = yaml.safe_load((ROOT / f"configs/{name}.yaml").read_text())
    wanted = {key: stored.get(key, rule.default) for key, rule in SCHEMA.keys.items()}
    wanted["streams"] = wanted["streams"] or wanted["cores"]

    written = json.loads((tmp_path / "config.json").read_text())
    assert written.pop("name") == name
    assert written == wanted
    assert stored.keys() < wanted.keys()

    package = (tmp_path / "ti_config_pkg.sv").read_text()
    header = (tmp_path / "ti_config.hpp").read_text()
    constants = dict(re.findall(r"localparam \w+(?: unsigned)? (\w+) = (?:1'b)?(\w+);", package))
    cpp = dict(re.findall(r"inline constexpr \w+ k(\w+) = ([\w:]+);", header))
    hardware = {k: v for k, v in wanted.items() if SCHEMA.keys[k].hardware}
    assert constants == {camel(key): in_sv(key, value) for key, value in hardware.items()}
    macros = re.findall(r"^`define TI_(\w+[A-Z])$", (tmp_path / "ti_config.svh").read_text(), re.M)
    assert {m.lower() for m in macros} == {k for k, value in wanted.items() if value is True}
    assert cpp == {camel(key): in_cpp(key, value) for key, value in hardware.items()}


def test_unchanged_files_keep_their_date(tmp_path):
    dates = []
    for _ in range(2):
        assert script("tiny", "--out", tmp_path).returncode == 0
        dates.append({p.name: p.stat().st_mtime_ns for p in tmp_path.iterdir()})
    assert dates[0] == dates[1]


@pytest.mark.parametrize("name", CONFIGS)
def test_the_json_schema_takes_what_is_written_and_nothing_else(name, tmp_path):
    configure.configure(name, [], tmp_path)
    config = json.loads((tmp_path / "config.json").read_text())
    schema = json.loads((tmp_path / "config.schema.json").read_text())

    assert complaints(schema, config) == []
    assert "'num_rays'" in complaints(schema, config | {"num_rays": 1})[0]
    for key in config:
        [message] = complaints(schema, {k: v for k, v in config.items() if k != key})
        assert f"'{key}'" in message
    for key, value in {"num_trv": 0, "trv_slots": 24, "counters": 1, "num_list": "1"}.items():
        assert len(complaints(schema, config | {key: value})) == 1


def test_the_document_has_the_table_of_the_schema(tmp_path):
    assert script("--check", DOCUMENT, script=FORMS).returncode == 0
    copy = tmp_path / "configuration.md"
    copy.write_text(DOCUMENT.read_text().replace("| `num_trv` |", "| `num_trvs` |"))
    assert script("--check", copy, script=FORMS).returncode == 1
    assert script("--write", copy, script=FORMS).returncode == 0
    assert copy.read_text() == DOCUMENT.read_text()
