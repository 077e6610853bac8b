# SPDX-License-Identifier: Apache-2.0
"""The gallery's page shows what the reports say, by itself; the project's scenes call for what they
are there for."""

import json
import re

import pytest
from agents.program import call, make

WORDS = {"CONFIG": "tiny", "ENGINE": "model", "SIZE": "24x16", "SPP": 1, "BOUNCES": 2}


def test_the_page_has_each_scene_with_the_figures_of_its_report(tiny, out):
    make("gallery", out, SCENES="cornell one_triangle", **WORDS).good()

    page = (out / "index.html").read_text()
    assert re.findall(r'<section id="(\w+)">', page) == ["cornell", "one_triangle"]
    for name in ("cornell", "one_triangle"):
        report = json.loads((out / name / "report.json").read_text())
        section = page.split(f'<section id="{name}">')[1].split("</section>")[0]
        assert f"{report['rays']:,}" in section
        for kind, count in report["rays_of"].items():
            assert (f"&nbsp; {kind}</td>" in section) == (count > 0)
        for row in report["plan"]:
            assert f"<td>{row['effect']}</td>" in section
        assert f"make render SCENE={name} CONFIG=tiny ENGINE=model SIZE=24x16 SPP=1" in section
        assert section.count("data:image/png;base64,") == 2  # the picture and its steps
    assert page.count("all hits right") == 2


def test_the_page_needs_nothing_but_itself(tiny, out):
    make("gallery", out, SCENES="cornell", **WORDS).good()
    page = (out / "index.html").read_text()
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert "<script" not in page


def test_cycles_are_shown_of_the_machine(tiny, out):
    make("gallery", out, SCENES="cornell", **(WORDS | {"ENGINE": "rtl"})).good()
    report = json.loads((out / "cornell/report.json").read_text())
    page = (out / "index.html").read_text()
    assert f"{report['cycles']:,}" in page
    assert f"{report['mrays_per_s']:.1f}" in page


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"SCENES": "cornell nowhere"}, "nowhere"),
        ({"SCENES": "cornell", "SIZE": "0x3"}, "SIZE=0x3"),
        ({"SCENES": "cornell", "EFFECTS": "colour"}, "colour"),
        ({"SCENES": "cornell", "ENGINE": "steam"}, "steam"),
        ({"SCENES": "cornell", "CONFIG": "none"}, "none"),
    ],
)
def test_bad_words_are_refused(tiny, out, words, said):
    make("gallery", out, **(WORDS | words)).refused(said)


def test_a_picture_that_is_refused_is_not_the_one_before(tiny, out):
    make("gallery", out, SCENES="cornell", **WORDS).good()
    before = (out / "index.html").read_bytes()
    again = make("gallery", out, SCENES="cornell", **(WORDS | {"BOUNCES": 1000}))
    assert again.status == 2
    assert "BOUNCES=1000" in again.stderr
    assert (out / "index.html").read_bytes() == before


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A function that gives the path of a scene that the project makes."""
    folder = tmp_path_factory.mktemp("scenes")

    def scene(name):
        call(["python", "scripts/make_scenes.py", "--big", folder, f"{name}.gltf"]).good()
        return folder / f"{name}.gltf"

    return scene


@pytest.mark.parametrize(
    ("name", "effects"),
    [
        ("cornell_glass", {"soft-shadows", "interreflection", "mirror", "glass"}),
        ("pavilion", {"shadows", "interreflection", "mirror"}),
        ("still_life", {"soft-shadows", "interreflection", "glossy", "mirror", "lens"}),
        ("windmill", {"shadows", "interreflection", "motion"}),
    ],
)
def test_a_scene_calls_for_the_effects_that_it_is_there_for(ti, made, tmp_path, name, effects):
    options = ["--size", "8x6", "--bounces", 2]
    if "motion" in effects:
        options += ["--frames", "0:2", "--fps", 8]
    run = ti.render(tmp_path / "out", made(name), *options).good()
    on = {row["effect"] for row in run.report["plan"] if row["on"]}
    assert on - {"dim-paths"} == effects
    assert run.stdout.count("warning:") == 0


def test_the_mill_turns_sixteen_frames_and_little_else(ti, made, tmp_path):
    words = ["--size", "64x48", "--frames", ":", "--fps", 8, "--effects", "none+motion"]
    run = ti.render(tmp_path / "out", made("windmill"), *words).good()
    frames = run.report["frames"]
    assert len(frames) == 16
    assert all(0 < f["traced_tiles"] < f["tiles"] / 2 for f in frames[1:])
    assert (tmp_path / "out/animation.png").is_file()
