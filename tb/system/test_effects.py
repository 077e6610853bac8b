# SPDX-License-Identifier: Apache-2.0
"""A picture gets the rays that its scene calls for, no others, and loses nothing by it."""

import json

import numpy as np
import pytest
from agents.program import SCENES, make

CORNELL = SCENES / "cornell.gltf"
EFFECTS = ["shadows", "soft-shadows", "interreflection", "glossy", "mirror", "glass", "lens"]
EFFECTS += ["roulette", "ao", "motion", "dim-paths"]


def radiance(run):
    return np.load(run.out / "radiance.npy")


def plan(run):
    return {row["effect"]: row for row in run.report["plan"]}


def picture(program, folder, scene, *options):
    words = ["--size", "24x16", "--spp", 2, "--dump", *options]
    return program.render(folder, scene, *words).good()


@pytest.fixture
def still_life(tmp_path):
    """Cornell's box with a mirror, glass and a gloss in it, and a lamp without an area."""
    scene = json.loads(CORNELL.read_text())
    white = scene["materials"][0]
    glossy = {"metallicFactor": 1.0, "roughnessFactor": 0.4}
    for mesh, name, factors, more in [
        (6, "mirror", {"metallicFactor": 1.0, "roughnessFactor": 0.0}, {}),
        (7, "glass", {}, {"KHR_materials_transmission": {"transmissionFactor": 1.0}}),
        (0, "gloss", glossy, {}),
    ]:
        scene["meshes"][mesh]["primitives"][0]["material"] = len(scene["materials"])
        base = white["pbrMetallicRoughness"]
        scene["materials"].append(
            white | {"name": name, "pbrMetallicRoughness": base | factors, "extensions": more}
        )
    scene["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 0.1}]}}
    scene["nodes"].append(
        {"translation": [0.4, 0.4, 0.1], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    )
    scene["scenes"][0]["nodes"].append(len(scene["nodes"]) - 1)
    path = tmp_path / "still_life.gltf"
    path.write_text(json.dumps(scene))
    return path


@pytest.mark.parametrize("scene", ["cornell", "knot", "still life", "one triangle"])
def test_what_is_left_out_changes_no_bit(ti, knot, still_life, tmp_path, scene):
    path = {"cornell": CORNELL, "knot": knot, "still life": still_life}
    path = path.get(scene, SCENES / "one_triangle.obj")
    some = picture(ti, tmp_path / "auto", path, "--effects", "auto+dim-paths")
    all_of_it = picture(ti, tmp_path / "all", path, "--effects", "all")

    assert some.read("radiance.npy") == all_of_it.read("radiance.npy")
    assert some.report["rays"] < all_of_it.report["rays"]
    for kind, rays in some.report["rays_of"].items():
        assert rays <= all_of_it.report["rays_of"][kind], kind


def test_the_picture_of_the_rtl_is_the_models(tiny, ti, still_life, tmp_path):
    rtl = picture(tiny, tmp_path / "rtl", still_life)
    model = picture(ti, tmp_path / "model", still_life)

    for name in ("image.png", "radiance.npy", "rays.npy", "hits.npy"):
        assert rtl.read(name) == model.read(name)
    assert rtl.report["rays_of"] == model.report["rays_of"]


def test_the_picture_of_embree_is_the_models_but_at_edges(ti, tmp_path):
    model = picture(ti, tmp_path / "model", CORNELL)
    words = ["--size", "24x16", "--spp", 2, "--dump"]
    embree = ti.render(tmp_path / "embree", CORNELL, *words, engine="embree").good()

    difference = np.abs(radiance(model) - radiance(embree)).max(axis=2)
    assert (difference < 1e-3 * radiance(model).max()).mean() > 0.98
    assert abs(radiance(model).mean() / radiance(embree).mean() - 1) < 0.01


def test_a_scene_lit_from_the_eye_costs_its_primary_rays(ti, tmp_path):
    run = picture(ti, tmp_path / "out", SCENES / "one_triangle.obj")

    assert run.report["rays"] == run.report["rays_of"]["primary"] == 24 * 16 * 2
    assert not any(row["on"] for row in run.report["plan"])
    assert radiance(run).max() > 0


def test_each_effect_has_a_row_with_its_reason_and_brings_no_more_rays(ti, still_life, tmp_path):
    run = picture(ti, tmp_path / "out", still_life)
    rows = plan(run)

    assert list(rows) == EFFECTS
    on = {name for name, row in rows.items() if row["on"]}
    assert on == {"shadows", "soft-shadows", "interreflection", "glossy", "mirror", "glass"}
    assert "mirror" in rows["mirror"]["reason"] and "no aperture" in rows["lens"]["reason"]
    for effect, kind in {"glossy": "glossy", "mirror": "mirror", "glass": "glass"}.items():
        assert 0 < run.report["rays_of"][kind] <= rows[effect]["rays"]
        without = picture(ti, tmp_path / effect, still_life, "--effects", f"auto-{effect}")
        assert without.report["rays_of"][kind] == 0
        assert plan(without)[effect]["bound"] == "the picture lacks it"
        assert without.read("radiance.npy") != run.read("radiance.npy")
        for name in EFFECTS:
            assert f"  {name}" in run.stdout


def test_more_samples_come_nearer_to_the_picture(ti, tmp_path):
    def of(spp, seed):
        words = ["--size", "16x16", "--spp", spp, "--seed", seed, "--dump", "--no-truth"]
        return radiance(ti.render(tmp_path / f"{spp}-{seed}", CORNELL, *words).good())

    true = of(1024, 9)
    errors = [np.sqrt(np.mean([(of(spp, s) - true) ** 2 for s in (1, 2)])) for spp in (4, 64)]
    # Random numbers would gain a factor of 4.
    assert errors[1] < errors[0] / 3.5


def test_make_takes_effects_and_bounces(tiny, tmp_path):
    words = {"CONFIG": "tiny", "ENGINE": "model", "SCENE": "cornell", "SIZE": "8x8"}
    none = make("render", tmp_path / "none", BOUNCES=0, **words).good().report
    ao = make("render", tmp_path / "ao", EFFECTS="ao", **words).good().report

    assert none["rays"] == 64 and none["provenance"]["bounces"] == 0
    assert ao["rays_of"]["occlusion"] > 0 and ao["rays_of"]["diffuse"] == 0
