# SPDX-License-Identifier: Apache-2.0
"""Documents name the commands, variables and files there are; their example runs; data parses."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from agents.bench import ROOT
from configure import configure

PAGES = sorted(
    [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("scenes/*.md")],
)
COMMANDS = (ROOT / "docs/commands.md").read_text()


def make_help():
    """Targets that `make help` lists."""
    # Without what a `make` above says to those below.
    env = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
    text = subprocess.run(
        ["make", "help"], cwd=ROOT, env=env, capture_output=True, text=True, check=True
    ).stdout
    return re.findall(r"^  make (\S+)", text, re.MULTILINE)


def test_each_command_of_make_help_is_on_its_page():
    documented = re.findall(r"^\| `make (\S+?)` \|", COMMANDS, re.MULTILINE)
    assert sorted(documented) == sorted(make_help())


def test_each_variable_of_the_makefile_is_on_the_page():
    names = re.findall(r"^(\w+) \?=", (ROOT / "Makefile").read_text(), re.MULTILINE)
    table = COMMANDS.split("## Variables")[1].split("##")[0]
    documented = {
        name
        for row in re.findall(r"^\| (`.+?) \|", table, re.MULTILINE)
        for name in re.findall(r"`(\w+)`", row)
    }
    assert names
    assert set(names) <= documented


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_to_files_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    links = re.findall(r"\]\(([^)\s#]+)[^)]*\)", text)
    missing = [
        link
        for link in links
        if not re.match(r"\w+:", link) and not (page.parent / link).resolve().exists()
    ]
    assert missing == []


@pytest.mark.parametrize(
    "picture", sorted(ROOT.glob("docs/pictures/*")), ids=lambda picture: picture.name
)
def test_pictures_are_small_and_shown(picture):
    assert picture.stat().st_size < 400_000
    assert any(f"pictures/{picture.name})" in page.read_text() for page in PAGES)


def test_the_python_example_runs(tmp_path):
    module = ROOT / "build/sw/python"
    if not list(module.glob("ti.*.so")):
        pytest.skip("build/sw/python/ti is not built; `make sw` does")
    configure("small", [], tmp_path / "build/config/small")
    (tmp_path / "build/sw").symlink_to(module.parent)
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    first = re.search(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", first[1]], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert re.fullmatch(r".*% hit, .* steps a ray\n.* rays are free\n", done.stdout), done.stdout


def test_ci_runs_the_script_of_the_project():
    jobs = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())["jobs"]
    steps = [step for job in jobs.values() for step in job["steps"]]
    assert [step["run"] for step in steps if step.get("run", "").startswith(".ci")] == [".ci/run"]
    assert os.access(ROOT / ".ci/run", os.X_OK)


def test_hooks_call_programs_and_rules_of_the_project():
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())["repos"][0]["hooks"]
    pinned = (ROOT / "requirements.txt").read_text()
    for hook in hooks:
        program, *words = hook["entry"].split()
        package = Path(program).name.removesuffix("-verilog-format").removesuffix("-verilog-lint")
        assert program.startswith("build/venv/bin/")
        assert f"\n{package}==" in pinned
        files = [word.split("=")[-1] for word in words if "lint/" in word]
        assert all((ROOT / file).is_file() for file in files)


def test_the_container_copies_what_there_is():
    container = json.loads((ROOT / ".devcontainer/devcontainer.json").read_text())
    dockerfile = (ROOT / ".devcontainer" / container["build"]["dockerfile"]).read_text()
    for line in re.findall(r"^COPY (.+) \S+$", dockerfile, re.MULTILINE):
        assert all((ROOT / name).is_file() for name in line.split())


def test_the_citation_names_the_paper():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["license"] == "Apache-2.0"
    assert citation["references"][0]["doi"] == "10.1145/2024156.2024194"


def test_the_speed_of_four_cores_in_the_tables_is_that_of_the_stored_bench():
    bench = json.loads((ROOT / "docs/results/bench-paper-4-dram.json").read_text())
    assert len(bench["cells"]) == 9
    readme = (ROOT / "README.md").read_text()
    gains = (ROOT / "docs/results/gains.md").read_text()
    for cell in bench["cells"]:
        assert cell["good"]
        speed, size = f"{cell['mrays_per_s']:.1f}", f"{cell['per_ray']['dram_bytes']:.0f}"
        assert f"| {cell['cycles']:,} | {speed} | {size} |" in readme
        scene = cell["scene"].split(".")[0]
        assert f"| {scene} | {cell['ray_type']} | {speed} |" in gains
