# SPDX-License-Identifier: Apache-2.0
"""`configure.py` takes overrides and fills folders; what cannot be built gets one sentence."""

import json
import re
from pathlib import Path

import configure
import pytest
from agents.configure_script import ROOT, SCHEMA, refused, script


def test_an_override_changes_one_key_and_the_name(tmp_path):
    assert script("tiny", "num_ist1=3", "counters=0", "--out", tmp_path).returncode == 0
    written = json.loads((tmp_path / "config.json").read_text())
    assert (written["num_ist1"], written["counters"]) == (3, False)
    assert written["name"] == "tiny num_ist1=3 counters=false"


@pytest.mark.parametrize(("cores", "given", "streams"), [(4, 0, 4), (4, 2, 2), (6, 6, 6)])
def test_streams_are_as_many_as_cores_unless_fewer_are_asked_for(cores, given, streams):
    overrides = [f"cores={cores}", f"streams={given}"]
    assert configure.load("tiny", overrides).values["streams"] == streams


def test_the_defaults_are_a_configuration(tmp_path):
    (tmp_path / "bare.yaml").write_text("num_trv: 24\n")
    # As many streams as cores, since none is given.
    assert configure.load(tmp_path / "bare.yaml").values == SCHEMA.defaults() | {"streams": 1}
    assert (SCHEMA.keys["exp_bits"].default, SCHEMA.keys["frac_bits"].default) in SCHEMA.formats


def test_a_folder_of_many_overrides_has_a_short_name_of_its_own():
    many = [" ".join(f"list_l2_bytes={n}" for n in range(first, 60)) for first in (0, 1)]
    names = [configure.folder_name(f"tiny {words}") for words in [*many, f"{many[0]} x=1"]]
    assert len(set(names)) == 3
    assert max(map(len, names)) <= 120
    assert configure.folder_name("tiny mem=fixed:1,2 exp_bits=7") == "tiny-mem=fixed_1_2-exp_bits=7"


# --- What is refused -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("override", "allowed"),
    [
        ("exp_bits=2", "3 to 8"),
        ("exp_bits=9", "3 to 8"),
        ("frac_bits=1", "2 to 23"),
        ("frac_bits=24", "2 to 23"),
        ("fp_add_stages=3", "4 to 10"),
        ("fp_add_stages=11", "4 to 10"),
        ("fp_cmp_stages=2", "0 to 1"),
        ("fp_mul_stages=2", "3 to 8"),
        ("fp_mul_stages=9", "3 to 8"),
        ("fp_rcp_bits_per_stage=0", "1 to 3"),
        ("fp_rcp_bits_per_stage=4", "1 to 3"),
        ("fp_rcp_end_stages=1", "2 to 5"),
        ("fp_rcp_end_stages=6", "2 to 5"),
        ("num_trv=0", "1 to 256"),
        ("num_list=2", "at most num_trv, 1"),
        ("rd_cycles=0", "1 to 3"),
        ("rd_cycles=4", "1 to 3"),
        ("trv_slots=24", "power of two from 2 to 256"),
        ("ist1_slots=1", "power of two from 2 to 256"),
        ("stack_depth=-1", "0 to 64"),
        ("stack_depth=65", "0 to 64"),
        ("lookup_stages=0", "1 to 5"),
        ("lookup_stages=6", "1 to 5"),
        ("fill_bytes=4", "power of two from 8 to 128"),
        ("fill_bytes=24", "power of two from 8 to 128"),
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


@pytest.mark.parametrize(("bits", "modes"), [(4, []), (5, ["rounding=zero"])])
def test_a_thick_ray_of_too_few_bits_is_named(bits, modes, tmp_path):
    out = tmp_path / "config"
    words = ["traversal=padded", "exp_bits=5", "fp_add_stages=4", *modes]
    refused(
        script("tiny", *words, f"frac_bits={bits - 1}", "--out", out),
        out,
        f"traversal is padded, but with frac_bits {bits - 1} the rounding errors",
    )
    assert configure.load("tiny", [*words, f"frac_bits={bits}"])


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        (["frac_bits=5", "rcp_table_bits=6"], "rcp_table_bits is 6, but must be at most frac_bits"),
        (
            ["rcp_table_bits=12", "rcp_newton_steps=0"],
            "rcp_table_bits 12 and rcp_newton_steps 0 leave an error of up to 3073 units",
        ),
        (
            ["rcp_newton_steps=0", "frac_bits=7", "fp_add_stages=4", "fp_rcp_end_stages=2"],
            "fp_add_stages is 4, but must be at most the stages of the reciprocal, 3",
        ),
    ],
)
def test_a_reciprocal_by_newton_steps_that_is_impossible_is_named(values, sentence, tmp_path):
    out = tmp_path / "config"
    refused(script("tiny", "reciprocal=newton", *values, "--out", out), out, sentence)


@pytest.mark.parametrize(
    "pair", [*SCHEMA.formats, (3, 2), (3, 4), (5, 16), (6, 23), (8, 2)], ids=str
)
@pytest.mark.parametrize("modes", [[], ["rounding=zero", "subnormals=flush"]], ids=str)
def test_every_format_is_taken_in_every_mode(pair, modes):
    keys = [f"exp_bits={pair[0]}", f"frac_bits={pair[1]}", "fp_add_stages=4", *modes]
    values = configure.load("tiny", keys).values
    assert (values["exp_bits"], values["frac_bits"]) == pair


@pytest.mark.parametrize(("pair", "least"), [((3, 5), 4), ((4, 9), 5), ((5, 17), 6)], ids=str)
def test_a_format_whose_inverses_overflow_too_soon_is_refused(pair, least, tmp_path):
    keys = [f"exp_bits={pair[0]}", f"frac_bits={pair[1]}", "fp_add_stages=4"]
    out = tmp_path / "config"
    refused(script("tiny", *keys, "--out", out), out, f"frac_bits {pair[1]} asks for {least} or")


def test_the_guard_of_an_interval_follows_the_rounding_unless_it_is_given(tmp_path):
    def guard(*overrides, file="tiny"):
        return configure.load(file, list(overrides)).values["interval_guard"]

    (tmp_path / "one.yaml").write_text("interval_guard: 1\n")
    assert (guard(), guard("rounding=zero")) == (4, 8)
    assert guard("reciprocal=newton") == 5
    assert guard("reciprocal=newton", "rcp_table_bits=10", "rcp_newton_steps=1") == 23
    assert guard("rounding=zero", "interval_guard=4") == 4
    assert guard("rounding=zero", file=tmp_path / "one.yaml") == 1


def test_an_l2_has_time_for_its_look_up(tmp_path):
    out = tmp_path / "config"
    keys = ("trv_l2_bytes=2048", "trv_l2_ways=2", "lookup_stages=3")
    sentence = "l2_latency is 5, but must be at least lookup_stages + 3, 6"
    refused(script("tiny", *keys, "l2_latency=5", "--out", out), out, sentence)
    assert configure.load("tiny", [*keys, "l2_latency=6"])
    assert configure.load("tiny", ["lookup_stages=3", "l2_latency=4"])  # there is no L2


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
        refused(
            script(name, "--out", out),
            out,
            "there are fpga, kv260, paper, small, tiny, watertight, or give",
        )


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
