# SPDX-License-Identifier: Apache-2.0
"""Wrong hits and pixels are counted by exact arithmetic; a sweep goes on; its page is whole."""

import csv
import json
import math
import re
import subprocess
import sys

import pytest
from agents.program import ROOT, SCENES, call

sys.path.insert(0, str(ROOT / "scripts"))
import accuracy_cluster
import accuracy_page
import accuracy_tables
from accuracy_costs import AccuracyError, Costs

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


def run_accuracy(ti, out, scene, *machines, kinds=KINDS, count=3000, more=()):
    """The lines of a run on machines, each a dict of keys."""
    words = ["accuracy", "--scene", scene, "--rays", kinds, "--count", count, "--size", "40x30"]
    out.mkdir(parents=True, exist_ok=True)
    for keys in machines:
        words += ["--config", ti.with_keys(out, **keys)]
    call([ti.path, *words, *more, "--out", out / "run"]).good()
    return [json.loads(line) for line in (out / "run/points.jsonl").read_text().splitlines()]


def counted(line):
    """The points of a line, by kind of rays."""
    return {point["rays"]: point for point in line["kinds"]}


def test_the_watertight_machine_has_no_crack_and_the_other_has_some(ti, tmp_path, ball):
    half = {"exp_bits": 5, "frac_bits": 10}
    machines = ({}, WATERTIGHT, half, WATERTIGHT | half)
    lines = run_accuracy(ti, tmp_path, ball, *machines)
    assert [line["format"] for line in lines] == ["(8,23)"] * 2 + ["(5,10)"] * 2
    for first in (0, 2):
        local, tight = (counted(line) for line in lines[first : first + 2])
        assert [*tight] == [*local] == KINDS.split()
        assert all(point["cracks"] == point["failed"] == 0 for point in tight.values())
        assert local["edges"]["cracks"] > 10
        for point in (*tight.values(), *local.values()):
            assert point["cracks"] <= point["missed"] + point["through"]
            assert point["through"] <= point["wrong_triangle"] <= point["count"]
            assert point["missed"] <= point["exact_hits"] <= point["count"]
            for error in ("t_ulp", "u_ulp", "v_ulp"):
                ulps = point[error]
                assert 0 <= ulps["median"] <= ulps["p99_9"] <= ulps["max"]
            assert ulps["median"] > 0
        for kind in KINDS.split():
            if kind != "secondary":  # one for each hit
                assert tight[kind]["count"] == 3000


def test_machines_together_count_as_each_alone(ti, tmp_path, ball):
    together = run_accuracy(ti, tmp_path / "both", ball, {}, WATERTIGHT, count=500)
    alone = [
        run_accuracy(ti, tmp_path / str(len(keys)), ball, keys, count=500)[0]
        for keys in ({}, WATERTIGHT)
    ]
    for line in (*together, *alone):
        del line["model_seconds"]
    assert together == alone


def test_cracks_stand_where_the_camera_sees_the_mesh(ti, tmp_path, ball):
    [line] = run_accuracy(ti, tmp_path, ball, {}, kinds="edges", count=3000)
    places = line["kinds"][0]["crack_places"]
    assert 10 < len(places) <= line["kinds"][0]["cracks"]
    # The camera sees the whole ball, a disc in the middle of 40x30 pixels.
    assert all(math.dist((x, y), (20, 15)) < 15 for x, y, _ in places)
    assert {seen for *_, seen in places} == {0, 1}


def test_the_picture_of_a_finer_format_has_fewer_wrong_pixels(ti, tmp_path, ball):
    coarse = {"exp_bits": 5, "frac_bits": 6}
    lines = run_accuracy(ti, tmp_path, ball, coarse, WATERTIGHT, kinds="edges", count=10)
    wrong = [line["picture"]["wrong_pixels"] for line in lines]
    assert wrong[0] > 10 > wrong[1]
    files = [tmp_path / "run" / line["picture"]["file"] for line in lines]
    reference = tmp_path / "run/reference.png"
    assert files[0].read_bytes() != reference.read_bytes()


def test_a_moved_scene_loses_bits(ti, tmp_path, ball):
    """At 1e5 a unit in the last place of x is 2^-7: corners move by up to half of that."""
    here, there = (
        run_accuracy(ti, tmp_path / name, ball, {}, kinds="uniform", count=2000, more=more)[0]
        for name, more in (("here", ()), ("there", ("--move", "100000,0,0")))
    )
    assert here["move"] == [] and there["move"] == [100000, 0, 0]
    assert there["kinds"][0]["t_ulp"]["p99_9"] > here["kinds"][0]["t_ulp"]["p99_9"]


def test_a_format_that_cannot_hold_the_scene_says_so_and_the_others_go_on(ti, tmp_path, ball):
    narrow = {"exp_bits": 3, "frac_bits": 6}
    more = ("--move", "0,1000,0")
    lines = run_accuracy(ti, tmp_path, ball, narrow, {}, kinds="edges", count=100, more=more)
    assert "refused" in lines[0] and "kinds" not in lines[0]
    assert "refused" not in lines[1] and lines[1]["kinds"][0]["count"] == 100


def test_fewer_rays_where_the_work_is_limited(ti, tmp_path, ball):
    more = ("--work", "20000")
    [line] = run_accuracy(ti, tmp_path, ball, {}, kinds="edges", count=100000, more=more)
    [kind] = line["kinds"]
    assert 32 <= kind["count"] < 100000
    assert (kind["steps_per_ray"] + kind["tests_per_ray"]) * kind["count"] < 30000


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"--rays": "edges corners"}, ["corners", "vertices"]),
        ({"--rays": " "}, ["RAYS=", "edges"]),
        ({"--scene": SCENES / "empty.ply"}, ["empty.ply"]),
        ({"--count": "0"}, ["--count"]),
        ({"--size": "0x5"}, ["SIZE=0x5"]),
        ({"--move": "1,2"}, ["--move"]),
        ({"--move": "0,1e39,0"}, ["--move"]),
        ({"--move": "3e38,3e38,3e38"}, ["one_triangle.obj", "move it less"]),
        ({"--work": "0"}, ["--work"]),
    ],
)
def test_bad_words_are_refused(ti, tmp_path, change, said):
    out = tmp_path / "none"
    words = {"--scene": SCENES / "one_triangle.obj", "--rays": "edges", "--count": "5"} | change
    options = [part for word in words.items() for part in word]
    command = [ti.path, "accuracy", "--config", ti.config, *options, "--out", out]
    call(command, out).refused(*said)


def test_a_machine_is_given_once(ti, tmp_path):
    out = tmp_path / "none"
    words = ["accuracy", "--config", ti.config, "--config", ti.config, "--rays", "edges"]
    command = [ti.path, *words, "--scene", SCENES / "one_triangle.obj", "--out", out]
    call(command, out).refused("8-23-local-plain", "once")


def line_of(fmt, test, walk, cracks, lut, mrays=None):
    rate = {"rate": cracks, "low": cracks / 2, "high": 2 * cracks + 9}
    ulps = {"median": 1, "p99_9": 2, "max": 3}
    kind = {"rays": "edges", "count": 100, "t_ulp": ulps, "u_ulp": ulps, "v_ulp": ulps}
    kind |= {f"{k}_per_million": rate for k in accuracy_tables.RATES}
    kind |= {"steps_per_ray": 9, "tests_per_ray": 3, "restarts_per_ray": 1}
    kind |= {"crack_places": [[1.5, 2.5, 1]]}
    point = {"scene": "a/ball.obj@1e6", "format": fmt, "test": test, "traversal": walk, "seed": 1}
    line = {
        "point": point,
        "kinds": [kind],
        "operators": {"ADD": 3},
        "operator_lut": lut,
        "operator_dsp": 4,
        "operator_ff": 5,
        "latency": {"step": 9, "test": 20, "hit": 40},
        "bytes": {"node": 8, "triangle": 48},
        "triangles": 7,
        "dropped": 0,
        "model_seconds": 1.0,
        "picture": {
            "width": 4,
            "height": 3,
            "wrong_pixels": 2,
            "psnr_db": None,
            "flip": 0.01,
            "file": "a.png",
            "flip_file": "b.png",
            "reference_file": "a.png",
        },
        "command": "make accuracy </script>",
    }
    if mrays:
        line["rtl"] = {"cycles_per_ray": 2.0, "mrays_per_s": mrays, "seconds": 3.0}
    return line


def test_the_page_needs_no_other_file_and_says_what_its_points_say(tmp_path):
    (tmp_path / "a.png").write_bytes(b"picture")
    lines = [
        line_of("(5,10)", "local", "plain", 17000, 1000, 12.5),
        line_of("(5,10)", "woop", "padded", 0, 1500, 9.5),
    ]
    refused = {k: v for k, v in lines[0].items() if k not in ("kinds", "picture", "rtl")}
    refused["point"] = refused["point"] | {"test": "np"}
    undrawn = line_of("(8,13)", "np", "padded", 1, 1200) | {"picture": None}
    text = accuracy_page.page([*lines, refused | {"refused": "<too large>"}, undrawn], tmp_path)

    assert "17,000 leak with local plain and 0 (95 %: at most 9) with woop padded" in text
    assert "of 12 pixels 2 and 2 are wrong, FLIP 0.0100 and 0.0100" in text
    assert "12.5 and 9.5 Mrays/s" in text
    assert "1,000 and 1,500 LUTs" in text and "1.50 times the LUTs" in text
    assert not re.search(r"""(src|href)=["'](?!\$\{pictures)|https?://|@import""", text)
    [data] = re.findall(r"const rows = (.*);", text)
    rows = json.loads(data.replace("<\\/", "</"))
    assert [row["machine"] for row in rows] == [
        "(5,10) local plain",
        "(5,10) woop padded",
        "(5,10) np plain",
        "(8,13) np padded",
    ]
    assert "flip" not in rows[3] and "refused" in rows[2]
    assert rows[0]["scene"] == "ball@1e6" and rows[0]["places"] == {"edges": [15, 25, 1]}
    assert rows[0]["picture"] == rows[0]["reference"] == 0 and rows[0]["differences"] is None
    assert text.count("</script>") == 1


def test_the_tables_have_a_row_for_each_kind_of_rays_and_each_refusal(tmp_path):
    lines = [line_of("(5,10)", "local", "plain", 17000, 1000)]
    refused = {k: v for k, v in lines[0].items() if k not in ("kinds", "picture", "triangles")}
    accuracy_tables.write_csv(tmp_path / "t.csv", [*lines, refused | {"refused": "too large"}])
    accuracy_tables.write_markdown(tmp_path / "t.md", [*lines, refused | {"refused": "too large"}])
    with (tmp_path / "t.csv").open() as file:
        first, second = csv.DictReader(file)
    for name in (
        "u_ulp_p99_9",
        "v_ulp_max",
        "wrong_pixels",
        "flip",
        "operator_ff",
        "model_seconds",
    ):
        assert first[name] != ""
    assert first["step_cycles"] == "9" and first["node_bytes"] == "8" and first["rays"] == "edges"
    undrawn = lines[0] | {"picture": None}
    accuracy_tables.write_markdown(tmp_path / "undrawn.md", [undrawn])
    assert accuracy_tables.csv_rows(undrawn)[0]["flip"] is None
    assert second["refused"] == "too large" and second["rays"] == ""
    assert len((tmp_path / "t.md").read_text().splitlines()) == 4


def test_cells_are_kept_by_what_they_depend_on(tmp_path):
    costs = Costs(tmp_path, tmp_path / "cells")
    keys = {"exp_bits": 8, "frac_bits": 23, "fp_add_stages": 3, "stack_depth": 4}
    file = costs.file_of(keys)
    assert file == costs.file_of(keys | {"stack_depth": 5, "triangle_test": "woop"})
    assert file != costs.file_of(keys | {"fp_add_stages": 4})
    assert file != costs.file_of(keys | {"frac_bits": 20})


@pytest.mark.parametrize(
    ("scheduler", "said"),
    [
        ("here", "tcp://host:port"),
        ("slurm:nodes=3", "no key `nodes`"),
        ("slurm:jobs=0", "jobs=0 must be a number from 1"),
        ("slurm:memory=8", "memory=8 must be a size"),
        ("slurm:walltime=soon", "walltime=soon must be a time"),
        ("slurm:queue=", "queue= must be the name of a partition"),
    ],
)
def test_a_scheduler_that_is_not_understood_is_refused(scheduler, said):
    with pytest.raises(AccuracyError, match=re.escape(said)):
        accuracy_cluster.check(scheduler)


def checks_python():
    python = ROOT / "build/checks/bin/python"
    if not python.exists():
        pytest.skip("build/checks is not there; `make accuracy` installs it")
    return python


def test_a_job_of_slurm_asks_for_what_was_said():
    code = (
        "import sys; sys.path.insert(0, 'scripts'); import accuracy_cluster as c; "
        "print(c.slurm_cluster(c.slurm_of('slurm:queue=short,cores=8,memory=6GB')).job_script())"
    )
    words = [checks_python(), "-c", code]
    script = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for line in ("-p short", "-n 1", "--cpus-per-task=8", "--mem=6G", "-t 04:00:00"):
        assert f"#SBATCH {line}\n" in script
    assert "build/checks/bin/python -m distributed.cli.dask_worker" in script
    assert "--nthreads 1 " in script


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"--scene": "scenes/one_triangle.obj@far"}, ["one_triangle.obj@far", "after @"]),
        ({"--scene": "scenes/one_triangle.obj@1,2"}, ["after @"]),
        ({"--scene": "scenes/one_triangle.obj@nan"}, ["after @"]),
        ({"--scheduler": "slurm:jobs=none"}, ["jobs=none"]),
        ({"--formats": "8,99"}, ["frac_bits"]),
        ({"--rays": "corners"}, ["corners"]),
    ],
)
def test_bad_words_of_a_sweep_are_refused(ti, tmp_path, change, said):
    words = {"--scene": "scenes/one_triangle.obj", "--rays": "edges", "--formats": "5,10"} | change
    options = [part for word in words.items() for part in word]
    command = [checks_python(), "scripts/accuracy.py", "--ti", ti.path, "--config", "tiny"]
    call([*command, *options, "--out", tmp_path / "out"]).refused(*said)


@pytest.mark.slow
def test_a_sweep_goes_on_and_keeps_what_it_has(ti, tmp_path, ball):
    command = [checks_python(), "scripts/accuracy.py", "--ti", ti.path, "--config", "tiny"]
    command += ["--scene", ball, f"{ball}@1e4", "--rays", "edges", "--count", "500"]
    command += ["--traversals", "plain", "--size", "40x30", "--out", tmp_path]
    words = ["--formats", "5,10", "--tests", "local woop"]
    assert "0 points are there, 4 to do" in call([*command, *words]).good().stdout
    first = (tmp_path / "points.jsonl").read_text()
    words = ["--formats", "5,10", "--tests", "local woop np"]
    assert "4 points are there, 2 to do" in call([*command, *words]).good().stdout
    assert (tmp_path / "points.jsonl").read_text().startswith(first)
    lines = [json.loads(line) for line in (tmp_path / "points.jsonl").read_text().splitlines()]
    names = {accuracy_tables.scene_name(line["point"]["scene"]) for line in lines}
    assert names == {"ball", "ball@1e4"} and len(lines) == 6
    for line in lines:
        assert "refused" in line or line["picture"]["flip"] >= 0
        assert line["command"].startswith("make accuracy") and line["operator_ff"] > 0
    assert "data:image/png" in (tmp_path / "index.html").read_text()
