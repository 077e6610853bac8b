# SPDX-License-Identifier: Apache-2.0
"""A key is one entry of the schema, which makes it in every form; a wrong entry is named."""

import json
import re
import subprocess

import config_schema
import pytest
import yaml
from agents.configure_script import DOCUMENT, FORMS, ROOT, complaints, refused, script

NEW = {  # entry, a value that is not the default, SystemVerilog, C++, a wrong value, the sentence
    "int": (
        "{type: int, range: [2, 64], power: true, default: 8, group: slots, text: 'Of tests.'}",
        *("16", "localparam int unsigned TestKey = 16;", "constexpr int kTestKey = 16;"),
        *("24", "test_key is 24, but must be a power of two from 2 to 64"),
    ),
    "bool": (
        "{type: bool, default: true, group: slots, text: 'Of tests.'}",
        *("false", "localparam bit TestKey = 1'b0;", "constexpr bool kTestKey = false;"),
        *("maybe", "test_key is maybe, but must be true or false"),
    ),
    "enum": (
        "{type: enum, values: [kd, wide_bvh], default: kd, group: slots, text: 'Of tests.'}",
        *("wide_bvh", "localparam test_key_e TestKey = TestKeyWideBvh;"),
        *("constexpr TestKey kTestKey = TestKey::kWideBvh;", "oct"),
        "test_key is oct, but must be one of kd, wide_bvh",
    ),
    "float": (
        "{type: float, range: [0, 2], default: 1.0, group: slots, text: 'Of tests.'}",
        *("0.5", "localparam real TestKey = 0.5;", "constexpr double kTestKey = 0.5;"),
        *("2.5", "test_key is 2.5, but must be a number from 0 to 2"),
    ),
}


def with_key(folder, entry):
    """A copy of the schema with one entry more."""
    path = folder / "schema.yaml"
    path.write_text(f"{config_schema.SCHEMA.read_text()}  test_key:\n    {entry}\n")
    return path


def compiler():
    """The compiler of the set-up."""
    return (ROOT / "build/setup.stamp").read_text().split("\n")[0]


@pytest.mark.parametrize("kind", NEW)
def test_one_entry_makes_a_key_in_every_form(kind, tmp_path):
    entry, value, sv, cpp, wrong, sentence = NEW[kind]
    schema, out = with_key(tmp_path, entry), tmp_path / "out"
    default = json.dumps(yaml.safe_load(entry)["default"])

    result = script("tiny", f"test_key={wrong}", "--schema", schema, "--out", out)
    refused(result, out, sentence)
    refused(script("tiny", "testkey=1", "--schema", schema, "--out", out), out, "mean test_key?")

    assert script("tiny", f"test_key={value}", "--schema", schema, "--out", out).returncode == 0
    assert sv in (out / "ti_config_pkg.sv").read_text()
    assert cpp in (out / "ti_config.hpp").read_text()
    config = json.loads((out / "config.json").read_text())
    rules = json.loads((out / "config.schema.json").read_text())
    assert config["test_key"] == yaml.safe_load(value)
    assert complaints(rules, config) == []
    assert complaints(rules, config | {"test_key": yaml.safe_load(wrong)}) != []
    lint = ["verilator", "--lint-only", "-Wall", "-Wno-UNUSEDPARAM", out / "ti_config_pkg.sv"]
    assert subprocess.run(lint, capture_output=True, text=True).stderr == ""

    page = tmp_path / "page.md"
    page.write_text(DOCUMENT.read_text())
    assert script("--schema", schema, "--write", page, script=FORMS).returncode == 0
    assert re.search(r"^\| `test_key` \| .* \| .* \| Of tests\. \|$", page.read_text(), re.M)

    header = tmp_path / "keys.hpp"
    assert script("--schema", schema, "--cpp", header, script=FORMS).returncode == 0
    default = "TestKey::kKd" if kind == "enum" else default
    assert re.search(rf"^  \w+ test_key = {default};$", header.read_text(), re.M)


PROGRAM = """
#include <iostream>
#include "base/config.hpp"
#include "base/error.hpp"
#include "ti_config.hpp"
int main(int, char** arguments) try {
  const ti::Config config = ti::load_config(arguments[1]);
  std::cout << (config.test_key == ti::config::kTestKey) << config.num_trv << '\\n';
} catch (const ti::Error& error) {
  std::cout << error.what() << '\\n';
}
"""


@pytest.mark.parametrize("kind", ["enum", "float"])
def test_the_loader_in_cpp_follows_the_schema(kind, tmp_path):
    entry, value, _, _, wrong, sentence = NEW[kind]
    schema, out = with_key(tmp_path, entry), tmp_path / "out"
    assert script("tiny", f"test_key={value}", "--schema", schema, "--out", out).returncode == 0
    header = out / "base/config_keys.hpp"
    assert script("--schema", schema, "--cpp", header, script=FORMS).returncode == 0
    (tmp_path / "main.cpp").write_text(PROGRAM)
    sources = [tmp_path / "main.cpp", ROOT / "sw/base/config.cpp", ROOT / "sw/io/file.cpp"]
    command = [compiler(), "-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{out}"]
    command += [f"-I{ROOT}/sw", *sources, "-o", tmp_path / "program", "-lfmt"]
    made = subprocess.run(command, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr

    def loaded(**changes):
        path = tmp_path / "config.json"
        config = json.loads((out / "config.json").read_text()) | changes
        path.write_text(json.dumps({k: v for k, v in config.items() if v is not None}))
        return subprocess.run([tmp_path / "program", path], capture_output=True, text=True).stdout

    assert loaded() == "11\n"
    assert sentence.split("must be")[1] in loaded(test_key=yaml.safe_load(wrong))
    assert "`test_key` is missing" in loaded(test_key=None)
    assert "unknown key `test_keys`" in loaded(test_keys=1)


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ("{type: long, default: 8, group: slots, text: a}", "the types are int, bool"),
        ("{type: int, default: 8, group: slots, text: a}", "numbers have a range"),
        ("{type: int, range: [1, 4], default: 8, group: slots, text: a}", "the default 8 is not"),
        ("{type: enum, default: a, group: slots, text: a}", "an enum has values"),
        ("{type: bool, default: true, group: none, text: a}", "there is no group none"),
        ("{type: bool, default: true, groups: slots, text: a}", "unknown field groups"),
        ("{type: bool, group: slots, text: a}", "not a schema: 'default'"),
        ("[", "not a schema"),
    ],
)
def test_a_wrong_entry_of_the_schema_is_named(entry, sentence, tmp_path):
    schema, out = with_key(tmp_path, entry), tmp_path / "out"
    refused(script("tiny", "--schema", schema, "--out", out), out, str(schema), sentence)
