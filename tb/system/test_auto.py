# SPDX-License-Identifier: Apache-2.0
"""`CONFIG=auto` takes the keys that a picture calls for, says why, and changes no hit."""

import json

import pytest
from agents.program import ROOT, SCENES, make

CORNELL = SCENES / "cornell.gltf"
FILES = ("image.png", "radiance.exr", "rays.npy", "hits.npy", "prims.npy")


def render(out, config, engine="model", **variables):
    return make(
        "render",
        out,
        SCENE=CORNELL,
        CONFIG=config,
        ENGINE=engine,
        SIZE="24x16",
        DUMP=1,
        **variables,
    )


def base_of(folder, words, like="small"):
    """A name of a configuration, or the file of one that is `like` but for that key."""
    if ":" not in words:
        return words
    path = folder / "base.yaml"
    path.write_text((ROOT / f"configs/{like}.yaml").read_text() + f"{words}\n")
    return path


def taken(run):
    """The keys of all decisions."""
    words = " ".join(row["set"] for row in run.report["machine_plan"]).split()
    return {key: json.loads(value) for key, value in (word.split("=") for word in words)}


@pytest.mark.parametrize(
    ("variables", "keys"),
    [
        ({}, {"watchdog_steps"}),
        ({"EFFECTS": "none"}, {"any_hit", "watchdog_steps"}),
        ({"BASE": "stack_depth: 20"}, {"restart", "stack_depth", "watchdog_steps"}),
        ({"BASE": "tiny", "EFFECTS": "mirror"}, {"any_hit", "watchdog_steps"}),
        ({"BASE": "trv_l2_bytes: 32768"}, {"watchdog_steps", "trv_l2_bytes"}),
    ],
    ids=["soft shadows", "no shadows", "deep stack", "other base", "L2"],
)
def test_the_machine_of_a_picture_has_its_keys_and_gives_its_hits(tmp_path, variables, keys):
    variables["BASE"] = base = base_of(tmp_path, variables.get("BASE", "small"))
    auto = render(tmp_path / "auto", "auto", **variables).good()
    plain = render(tmp_path / "plain", base, **variables).good()

    chosen = taken(auto)
    assert set(chosen) == keys
    assert {key: auto.report["keys"][key] for key in chosen} == chosen
    same = set(auto.report["keys"]) - keys - {"name"}
    assert all(auto.report["keys"][key] == plain.report["keys"][key] for key in same)
    assert auto.report["tree"] == plain.report["tree"]
    assert all(auto.read(name) == plain.read(name) for name in FILES)
    for row in auto.report["machine_plan"]:
        assert row["reason"] in auto.stdout and row["set"] in auto.stdout


@pytest.mark.parametrize("effects", ["auto", "none"])
def test_the_rtl_of_a_picture_gives_the_hits_of_the_base(tmp_path, effects):
    """A base whose stack the tree of the box just fills, so that all keys are taken."""
    base = base_of(tmp_path, "stack_depth: 16", like="tiny")
    auto = render(tmp_path / "auto", "auto", "rtl", EFFECTS=effects, BASE=base).good()
    plain = render(tmp_path / "plain", base, "rtl", EFFECTS=effects).good()

    assert auto.report["keys"]["restart"] is False
    assert auto.report["keys"]["any_hit"] is (effects == "auto")
    assert all(auto.read(name) == plain.read(name) for name in FILES)
    assert auto.report["cycles"] == plain.report["cycles"]


def test_keys_of_the_user_have_the_last_word(tmp_path):
    auto = render(tmp_path / "auto", "auto", EFFECTS="none", SET="any_hit=true").good()
    assert taken(auto)["any_hit"] is False
    assert auto.report["keys"]["any_hit"] is True


def test_every_picture_says_what_it_calls_for(tmp_path):
    run = render(tmp_path / "out", "small", EFFECTS="none").good()
    assert taken(run)["any_hit"] is False
    assert run.report["keys"]["any_hit"] is True


def test_a_machine_without_any_hit_rays_refuses_them_before_it_traces(tmp_path):
    refused = ("any_hit is false", "set it to true")
    render(tmp_path / "a", "small", SET="any_hit=false").refused("soft-shadows", *refused)
    render(tmp_path / "b", "auto", SET="any_hit=false").refused("soft-shadows", *refused)
    trace = {"SCENE": CORNELL, "ENGINE": "model", "SET": "any_hit=false"}
    make("trace", tmp_path / "c", RAYS="ao:100", **trace).refused(*refused)
    make("trace", tmp_path / "d", RAYS="primary:100", **trace).good()


def test_a_machine_without_restarts_refuses_a_tree_that_may_overflow_its_stack(tmp_path):
    small = {"config": "small", "EFFECTS": "none"}
    refused = render(tmp_path / "a", SET="restart=false stack_depth=15", **small)
    refused.refused("16 entries", "stack_depth is 15")
    render(tmp_path / "b", SET="restart=false stack_depth=16", **small).good()


@pytest.mark.parametrize("target", ["trace", "engine", "config", "operators"])
def test_auto_belongs_to_render_alone(target):
    make(target, CONFIG="auto", RAYS="random:10").refused("auto", "`make render` alone")


def test_the_file_of_the_keys_does_not_stay(tmp_path):
    render(tmp_path / "auto", "auto").good()
    assert not list((ROOT / "build/auto").iterdir())
