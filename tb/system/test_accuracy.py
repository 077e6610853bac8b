# SPDX-License-Identifier: Apache-2.0
"""Wrong hits are counted by exact arithmetic; the page of a sweep is whole."""

import json
import math
import re
import sys

import pytest
from agents.program import ROOT, SCENES, call

sys.path.insert(0, str(ROOT / "scripts"))
import accuracy_page

KINDS = "uniform edges vertices grazing far secondary"
WATERTIGHT = {"triangle_test": "woop", "traversal": "padded"}


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """A closed mesh: 24 x 12 patches of a sphere."""
    path = tmp_path_factory.mktemp("mesh") / "ball.obj"
    around, rows = 24, 12
    places = [(0.0, 0.0, 1.0)]
    for row in range(1, rows):
        polar = math.pi * row / rows
        for i in range(around):
            turn = 2 * math.pi * i / around
            sine = math.sin(polar)
            places.append((sine * math.cos(turn), sine * math.sin(turn), math.cos(polar)))
    places.append((0.0, 0.0, -1.0))

    def at(row, i):
        if row in (0, rows):
            return 1 if row == 0 else len(places)
        return 2 + (row - 1) * around + i % around

    faces = []
    for row in range(rows):
        for i in range(around):
            corners = [at(row, i), at(row + 1, i), at(row + 1, i + 1), at(row, i + 1)]
            for face in (corners[:3], [corners[0], *corners[2:]]):
                if len(set(face)) == 3:
                    faces.append(face)
    lines = ["v {:.9g} {:.9g} {:.9g}".format(*p) for p in places]
    path.write_text("\n".join(lines + ["f {} {} {}".format(*f) for f in faces]) + "\n")
    return path


def counted(ti, folder, scene, kinds=KINDS, count=3000, **keys):
    """The points of a run, by kind of rays."""
    out = folder / "counted.json"
    config = ti.with_keys(folder, **keys)
    words = ["accuracy", "--config", config, "--scene", scene, "--rays", kinds]
    call([ti.path, *words, "--count", count, "--out", out]).good()
    points = json.loads(out.read_text())["points"]
    return {point["rays"]: point for point in points}


def test_the_watertight_machine_has_no_crack_and_the_other_has_some(ti, tmp_path, ball):
    for fmt in ({"exp_bits": 5, "frac_bits": 10}, {}):
        tight = counted(ti, tmp_path, ball, **WATERTIGHT, **fmt)
        local = counted(ti, tmp_path, ball, **fmt)
        assert [*tight] == [*local] == KINDS.split()
        assert all(point["cracks"] == point["failed"] == 0 for point in tight.values())
        assert local["edges"]["cracks"] > 10
        for point in (*tight.values(), *local.values()):
            assert point["cracks"] <= point["missed"] + point["through"]
            assert point["through"] <= point["wrong_triangle"] <= point["count"]
            assert point["missed"] <= point["exact_hits"] <= point["count"]
            ulps = point["t_ulp"]
            assert 0 <= ulps["median"] <= ulps["p99_9"] <= ulps["max"]
        for kind in KINDS.split():
            if kind != "secondary":  # one for each hit
                assert tight[kind]["count"] == 3000


def test_the_same_seed_counts_the_same(ti, tmp_path, ball):
    assert counted(ti, tmp_path, ball, count=500) == counted(ti, tmp_path, ball, count=500)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"--rays": "edges corners"}, ["corners", "vertices"]),
        ({"--rays": " "}, ["RAYS=", "edges"]),
        ({"--scene": SCENES / "empty.ply"}, ["empty.ply"]),
        ({"--count": "0"}, ["--count"]),
    ],
)
def test_bad_words_are_refused(ti, tmp_path, change, said):
    out = tmp_path / "none.json"
    words = {"--scene": SCENES / "one_triangle.obj", "--rays": "edges", "--count": "5"} | change
    options = [part for word in words.items() for part in word]
    command = [ti.path, "accuracy", "--config", ti.config, *options, "--out", out]
    call(command, out).refused(*said)


def line_of(test, walk, cracks, lut):
    rate = {"rate": cracks, "low": cracks / 2, "high": 2 * cracks + 9}
    kind = {"rays": "edges", "count": 100, "t_ulp": {"median": 1, "p99_9": 2, "max": 3}}
    kind |= {f"{k}_per_million": rate for k in ("missed", "cracks", "false_hits", "self_hits")}
    kind |= {"wrong_triangle_per_million": rate, "steps_per_ray": 9, "tests_per_ray": 3}
    return {
        "point": {"scene": "a/ball.obj", "format": "(5,10)", "test": test, "traversal": walk},
        "kinds": [kind],
        "operator_lut": lut,
        "operator_dsp": 4,
        "operator_ff": 5,
        "latency": {"step": 9, "test": 20, "hit": 40},
        "bytes": {"node": 8, "triangle": 48},
        "seconds": 1.0,
        "command": "make accuracy </script>",
    }


def test_the_page_needs_no_other_file_and_says_what_its_points_say():
    lines = [line_of("local", "plain", 17000, 1000), line_of("woop", "padded", 0, 1500)]
    text = accuracy_page.page(lines)

    assert "17,000 slip through with the test local and 0 (95 %: at most 9)" in text
    assert "1.50 times the LUTs" in text
    assert not re.search(r"(src|href)=", text)
    [data] = re.findall(r"const rows = (.*);", text)
    rows = json.loads(data.replace("<\\/", "</"))
    assert [row["machine"] for row in rows] == ["(5,10) local plain", "(5,10) woop padded"]
    assert text.count("</script>") == 1
