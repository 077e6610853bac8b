# SPDX-License-Identifier: Apache-2.0
"""The table of trees has a row a scene and kind of rays, and says which scene is missing."""

import sys

from agents.program import ROOT, call


def test_a_scene_has_its_rows_and_a_missing_one_a_message(ti, benchmark, tmp_path):
    scene = benchmark("sibenik")
    (tmp_path / scene.name).symlink_to(scene)
    script = ROOT / "scripts/tree_table.py"
    run = call([sys.executable, script, ti.path, ti.config, tmp_path, 2000]).good()

    rows = [line for line in run.stdout.splitlines() if line.startswith("sibenik")]
    assert [row.split()[1] for row in rows] == ["primary", "ao", "diffuse"]
    assert "conference     primary  skipped:" in run.stdout
