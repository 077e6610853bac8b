# SPDX-License-Identifier: Apache-2.0
"""Variants of a machine are measured on the same rays and stand side by side in tables."""

import csv
import json

import pytest
from agents.program import make

WORDS = {"CONFIG": "tiny", "SCENES": "cornell", "RAYS": "primary diffuse", "N": 1000}
WORDS |= {"SIZE": "32x32"}


def rows_of(out):
    """Rows of compare.csv by variant and kind of rays."""
    with (out / "compare.csv").open(newline="") as file:
        return {(row["variant"], row["ray_type"]): row for row in csv.DictReader(file)}


def test_each_variant_stands_beside_the_machine_as_it_is(tiny, out):
    make("compare", out, VARIANTS="stack_depth=4;  tree_test_cost=3   layout=dfl", **WORDS).good()

    rows = rows_of(out)
    variants = ["", "stack_depth=4", "tree_test_cost=3 layout=dfl"]
    assert [*rows] == [(v, kind) for v in variants for kind in ("primary", "diffuse")]
    # Cheap tests were said to be dear: another tree, with fewer tests and more steps.
    for kind in ("primary", "diffuse"):
        plain, tree = rows["", kind], rows[variants[2], kind]
        assert float(tree["tests_per_ray"]) < float(plain["tests_per_ray"])
        assert float(tree["steps_per_ray"]) > float(plain["steps_per_ray"])
        assert rows[variants[1], kind]["rays"] == plain["rays"] == tree["rays"]
    text = (out / "compare.md").read_text()
    primary = rows["", "primary"]
    assert f"| as it is | {float(primary['mrays_per_s']):.1f} | " in text
    assert "| `tree_test_cost=3 layout=dfl` | " in text


def test_a_comparison_goes_on_where_it_was_stopped(tiny, out):
    make("compare", out, VARIANTS="layout=dfl", **WORDS).good()
    again = make("compare", out, VARIANTS="layout=dfl; tree_test_cost=3", **WORDS).good()

    assert again.stdout.count("going on behind 2 cells") == 2
    assert len(rows_of(out)) == 6


def test_a_variant_whose_hits_differ_in_a_bit_is_named(tiny, out):
    make("compare", out, VARIANTS="layout=dfl", **WORDS).good()
    rows = rows_of(out)
    assert [row["same_hits"] for row in rows.values()] == ["1"] * 4
    assert "| `layout=dfl` | 2 of 2 |" in (out / "compare.md").read_text()

    # The same command takes the cells from the file, one of them with the hits of something else.
    file = out / "layout=dfl/bench.json"
    content = json.loads(file.read_text())
    content["cells"][1]["hits_sha256"] = "0" * 64
    file.write_text(json.dumps(content))
    make("compare", out, VARIANTS="layout=dfl", **WORDS).good()
    assert rows_of(out)["layout=dfl", "diffuse"]["same_hits"] == "0"
    assert "| `layout=dfl` | 1 of 2 |" in (out / "compare.md").read_text()


def test_a_variant_may_have_other_cores(tiny, out):
    make("compare", out, CORES=1, VARIANTS="cores=2", **WORDS).good()

    rows = rows_of(out)
    assert int(rows["cores=2", "diffuse"]["cycles"]) < int(rows["", "diffuse"]["cycles"])


def test_figures_are_those_of_the_bench(tiny, tmp_path):
    one, both = tmp_path / "one", tmp_path / "both"
    make("bench", one, SET="layout=dfl", **WORDS).good()
    make("compare", both, VARIANTS="layout=dfl", **WORDS).good()

    cells = json.loads((one / "bench.json").read_text())["cells"]
    rows = rows_of(both)
    for cell in cells:
        assert int(rows["layout=dfl", cell["ray_type"]]["cycles"]) == cell["cycles"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"VARIANTS": "layout=dfl; num_trv=0"}, "num_trv"),
        ({"VARIANTS": "layout=dfl; colour=red"}, "colour"),
        ({"VARIANTS": "layout"}, "layout"),
        ({"VARIANTS": ""}, "VARIANTS"),
        ({"VARIANTS": "layout=dfl", "SCENES": "nowhere"}, "nowhere"),
        ({"VARIANTS": "layout=dfl", "N": 10}, "10"),
        ({"VARIANTS": "layout=dfl", "MEM": "slow"}, "slow"),
    ],
)
def test_bad_words_are_refused(out, words, said):
    make("compare", out, **(WORDS | words)).refused(said)
