# SPDX-License-Identifier: Apache-2.0
"""`configure.py` writes one set of values in every form; what cannot be built gets one sentence."""

import json
import re
import subprocess
import sys
from pathlib import Path

import config_schema
import configure
import jsonschema
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/configure.py"
FORMS = ROOT / "scripts/config_forms.py"
DOCUMENT = ROOT / "docs/configuration.md"
SCHEMA = config_schema.load()
CONFIGS = sorted(path.stem for path in (ROOT / "configs").glob("*.yaml") if path.stem != "schema")


def script(*arguments, script=SCRIPT):
    command = [sys.executable, str(script), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def camel(key):
    return key.title().replace("_", "")


def refused(result, out, *words):
    """One sentence with these words, status 2, nothing written."""
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1
    assert [word for word in words if word not in result.stderr] == [], result.stderr
    assert not out.exists()


def in_sv(key, value):
    """A value in SystemVerilog, without a prefix of its width."""
    return camel(f"{key}_{value}") if SCHEMA.keys[key].kind == "enum" else str(int(value))


def in_cpp(key, value):
    """A value in C++."""
    enum = SCHEMA.keys[key].kind == "enum"
    return f"{camel(key)}::k{camel(value)}" if enum else json.dumps(value)


# --- Every form of a configuration ---------------------------------------------------------------


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


def test_an_override_changes_one_key_and_the_name(tmp_path):
    assert script("tiny", "num_ist1=3", "counters=0", "--out", tmp_path).returncode == 0
    written = json.loads((tmp_path / "config.json").read_text())
    assert (written["num_ist1"], written["counters"]) == (3, False)
    assert written["name"] == "tiny num_ist1=3 counters=false"


def test_unchanged_files_keep_their_date(tmp_path):
    dates = []
    for _ in range(2):
        assert script("tiny", "--out", tmp_path).returncode == 0
        dates.append({p.name: p.stat().st_mtime_ns for p in tmp_path.iterdir()})
    assert dates[0] == dates[1]


def complaints(schema, value):
    """What JSON Schema says of a value."""
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    return [error.message for error in validator.iter_errors(value)]


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


# --- A key is one entry of the schema ------------------------------------------------------------

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


@pytest.mark.parametrize(("cores", "given", "streams"), [(4, 0, 4), (4, 2, 2), (6, 6, 6)])
def test_streams_are_as_many_as_cores_unless_fewer_are_asked_for(cores, given, streams):
    overrides = [f"cores={cores}", f"streams={given}"]
    assert configure.load("tiny", overrides).values["streams"] == streams


# --- What is refused -----------------------------------------------------------------------------


def test_the_defaults_are_a_configuration(tmp_path):
    (tmp_path / "bare.yaml").write_text("num_trv: 24\n")
    # As many streams as cores, since none is given.
    assert configure.load(tmp_path / "bare.yaml").values == SCHEMA.defaults() | {"streams": 1}
    assert (SCHEMA.keys["exp_bits"].default, SCHEMA.keys["frac_bits"].default) in SCHEMA.formats


@pytest.mark.parametrize(
    ("override", "allowed"),
    [
        ("exp_bits=2", "3 to 8"),
        ("exp_bits=9", "3 to 8"),
        ("frac_bits=1", "2 to 23"),
        ("frac_bits=24", "2 to 23"),
        ("fp_add_stages=3", "4 to 7"),
        ("fp_add_stages=8", "4 to 7"),
        ("fp_mul_stages=2", "3 to 5"),
        ("fp_mul_stages=6", "3 to 5"),
        ("fp_rcp_bits_per_stage=0", "1 to 3"),
        ("fp_rcp_bits_per_stage=4", "1 to 3"),
        ("fp_rcp_end_stages=1", "2 to 4"),
        ("fp_rcp_end_stages=5", "2 to 4"),
        ("num_trv=0", "1 to 256"),
        ("num_list=2", "at most num_trv, 1"),
        ("rd_cycles=0", "1 to 3"),
        ("rd_cycles=4", "1 to 3"),
        ("trv_slots=24", "power of two from 2 to 256"),
        ("ist1_slots=1", "power of two from 2 to 256"),
        ("stack_depth=-1", "0 to 64"),
        ("stack_depth=65", "0 to 64"),
        ("line_bytes=16", "power of two from 32 to 128"),
        ("line_bytes=96", "power of two from 32 to 128"),
        ("trv_l1_ways=0", "1 to 16"),
        ("trv_l1_bytes=1536", "128, times a power of two"),
        ("list_l1_bytes=64", "128, times a power of two"),
        ("ist1_rows=9", "1 to ist1_slots, 8"),
        ("l2_latency=3", "4 to 256"),
        ("l2_latency=257", "4 to 256"),
        ("trv_l2_bytes=-1", "0 to 67108864"),
        ("trv_l2_bytes=3072", "trv_l2_ways * trv_l2_banks, 2048, times a power of two"),
        ("ist1_l2_bytes=1024", "ist1_l2_ways * ist1_l2_banks, 2048, times a power of two"),
        ("list_l2_bytes=1536", "line_bytes * list_l2_ways, 512, times a power of two"),
        ("list_l2_ways=3", "power of two from 1 to 16"),
        ("trv_l2_banks=3", "power of two from 1 to 32"),
        ("trv_l2_banks=64", "power of two from 1 to 32"),
        ("ist1_l2_rows=0", "1 to 256"),
        ("list_rows=0", "1 to 256"),
        ("streams=3", "streams is 3, but must be 0 or divide cores, 1"),
        ("watchdog_steps=65536", "1 to 65535"),
        ("addr_bits=20", "21 to 64"),
        ("early_exit=2", "true or false"),
        ("ray_accumulation=none", "one of gather, retry, blocking"),
        ("layout=bvh", "one of odfl, dfl"),
        ("counters=2", "true or false"),
        ("clock_mhz=0", "1 to 10000"),
        ("num_trv=two", "num_trv is two, but must be a whole number"),
        ("num_trv=1.5", "num_trv is 1.5, but"),
        ("num_trv=true", "num_trv is true, but"),
        ("num_rays=1", "unknown key num_rays; did you mean num_trv?"),
        ("xyzzy=1", "unknown key xyzzy; the keys are exp_bits"),
    ],
)
def test_an_impossible_value_names_file_key_and_range(override, allowed, tmp_path):
    out = tmp_path / "config"
    result = script("tiny", override, "--out", out)
    refused(result, out, "tiny.yaml", allowed)
    assert re.search(rf"\b{override.split('=')[0]}\b", result.stderr)


def test_a_kind_without_an_l2_may_have_any_shape_of_one():
    values = configure.load(
        "tiny", ["trv_l2_ways=16", "trv_l2_banks=32", "list_l2_bytes=512"]
    ).values
    assert (values["trv_l2_bytes"], values["list_l2_bytes"]) == (0, 512)


def test_an_adder_deeper_than_the_reciprocal_is_named(tmp_path):
    values = ["frac_bits=2", "fp_rcp_bits_per_stage=3", "fp_add_stages=5"]
    out = tmp_path / "config"
    sentence = "fp_add_stages is 5, but must be at most the stages of the reciprocal, 4"
    refused(script("tiny", *values, "--out", out), out, sentence)


def test_a_format_without_a_model_is_refused_but_for_units(tmp_path):
    out = tmp_path / "config"
    for place in ("--out", "--build"):
        result = script("tiny", "exp_bits=4", place, out)
        refused(result, out, "tiny.yaml", "(4,23)", "(8,23), (8,20)", "configs/schema.yaml")
    for exp_bits, frac_bits in SCHEMA.formats:
        keys = [f"exp_bits={exp_bits}", f"frac_bits={frac_bits}"]
        assert script("tiny", *keys, "--out", tmp_path / "model").returncode == 0
    assert script("tiny", "exp_bits=4", "--any-format", "--out", out).returncode == 0
    assert configure.configure("tiny", ["exp_bits=4"], out)["exp_bits"] == 4


@pytest.mark.parametrize("override", ["num_trv", "num_trv=", "=1"])
def test_an_override_that_is_none_is_named(override, tmp_path):
    out = tmp_path / "config"
    refused(script("tiny", override, "--out", out), out, override)


@pytest.mark.parametrize(
    ("edit", "sentence"),
    [
        (lambda text: text.replace("num_trv: 1 ", "num_trvs: 1 "), "did you mean num_trv?"),
        (lambda text: text.replace("num_trv: 1 ", "7: 1 "), "unknown key 7"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: many "), "num_trv is many"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: true "), "num_trv is True"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: 1.5 "), "num_trv is 1.5"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: "), "num_trv is None"),
        (lambda text: text.replace("num_trv: 1 ", "num_trv: [1 "), "is not YAML"),
        (lambda text: "", "holds no keys"),
    ],
)
def test_a_broken_file_is_named(edit, sentence, tmp_path):
    path, out = tmp_path / "broken.yaml", tmp_path / "config"
    path.write_text(edit((ROOT / "configs/tiny.yaml").read_text()))
    refused(script(path, "--out", out), out, str(path), sentence)


def test_an_unknown_name_lists_the_known_ones(tmp_path):
    out = tmp_path / "config"
    for name in ("nothing", "schema"):
        refused(script(name, "--out", out), out, "there are paper, small, tiny, or give")


# --- Where builds are ----------------------------------------------------------------------------


def places(name, *overrides):
    configuration = configure.load(name, list(overrides))
    return configuration.engine, configuration.folder


def test_one_machine_has_one_engine():
    engine, folder = places("tiny", "num_trv=2", "trv_slots=16")

    assert places("tiny", "trv_slots=16", "num_trv=2") == (engine, folder)
    assert places("tiny", "trv_slots=0x10", "num_list=1", "num_trv=2") == (engine, folder)
    assert configure.load("tiny", ["num_trv=1"]).name == "tiny"
    other = configure.load("tiny", ["clock_mhz=600", "num_trv=2", "trv_slots=16"])
    assert other.name == "tiny num_trv=2 trv_slots=16 clock_mhz=600"
    assert other.engine == engine and other.folder != folder
    assert str(folder) == "config/tiny-num_trv-2-trv_slots-16"


@pytest.mark.parametrize("key", [key.name for key in SCHEMA.keys.values() if key.hardware])
def test_every_key_of_the_rtl_makes_another_machine(key):
    rule, value = SCHEMA.keys[key], configure.load("tiny").values[key]
    if rule.kind == "int":
        near = (value * 2, value + 1, value // 2, value - 1)
        others = [v for v in near if v != value and rule.allows(v)]
    else:
        others = [v for v in rule.values or (True, False) if v != value]
    other = others[0]
    a = configure.Configuration(SCHEMA, Path("a.yaml"), SCHEMA.defaults() | {key: value}, {})
    b = configure.Configuration(SCHEMA, Path("a.yaml"), SCHEMA.defaults() | {key: other}, {})

    assert a.machine != b.machine and a.engine != b.engine
    assert a.files_of_machine() != b.files_of_machine()


def test_files_share_an_engine_exactly_when_their_machine_is_one(tmp_path):
    text = (ROOT / "configs/tiny.yaml").read_text()
    paths = [tmp_path / name for name in ("a/my tiny.yaml", "b/my tiny.yaml", "c/other.yaml")]
    for path, units in zip(paths, ("1", "2", "1"), strict=True):
        path.parent.mkdir()
        path.write_text(text.replace("num_trv: 1 ", f"num_trv: {units} "))
    engines, folders = zip(*map(places, paths), strict=True)

    assert len(set(folders)) == 3
    assert engines[0] == engines[2] == places("tiny")[0] != engines[1]
    assert all(re.fullmatch(r"[\w/-]+", str(path)) for path in [*engines, *folders])


def test_a_long_list_of_overrides_still_names_a_folder():
    many = [f"{unit}_rows=1" for unit in ("trv", "list", "ist1")]
    many += [f"{unit}_slots=128" for unit in ("trv", "list", "ist1")] + ["watchdog_steps=99"]

    assert len(str(places("tiny", *many)[1])) < 40
    assert places("tiny", *many)[1] != places("tiny", *many[1:])[1]


def test_build_says_and_fills_its_folders(tmp_path):
    result = script("tiny", "clock_mhz=7", "--build", tmp_path)
    folder, engine = map(Path, result.stdout.split())

    assert (folder, engine) == (
        tmp_path / "config/tiny-clock_mhz-7",
        tmp_path / configure.load("tiny").engine,
    )
    assert json.loads((folder / "config.json").read_text())["clock_mhz"] == 7
    for path in (engine / "config").iterdir():
        assert path.read_text() == (folder / path.name).read_text()
    assert (folder / "engine").resolve() == engine.resolve()
