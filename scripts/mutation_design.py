# SPDX-License-Identifier: Apache-2.0
"""The RTL and its tests as scripts/mutation_score.py sees them: which mutations, which checks."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

import configure
import mutants
import mutation_switch as switch
import mutations
import operators
import rtl_syntax
from mutants import LOCK_STEP, ROOT
from mutations import Mutation

# Made from other files, so that a mutation is found by making them again.
MADE = ("rtl/host/ti_regs.sv", "rtl/host/ti_regs_pkg.sv")
# What all tests are made of, beside their own files.
TESTS = ("tb", "sw", "sim", "scenes", "configs")
SUFFIXES = (".py", ".cpp", ".hpp", ".sv", ".vlt")


class Design:
    """The RTL: its mutations that compile, by number, and which module is where."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.files, headers = rtl_syntax.design(ROOT)
        configure.configure("tiny", [], folder / "config")
        headers = [*headers, folder / "config"]
        found = mutations.find(ROOT, self.files, headers, left_out=MADE)
        self.digest = switch.digest([ROOT / file for file in self.files], found)
        self.all = len(found)
        self.numbered = dict(switch.compilable(ROOT, folder, self.files, found))
        self.children = rtl_syntax.instances(ROOT, self.files, headers)
        self.built: dict[tuple[str, str], set[str]] = {}

    def modules(self, shape: str, top: str) -> set[str]:
        """The modules of which a configuration has an instance."""
        if (shape, top) not in self.built:
            name, *overrides = shape.split()
            config = self.folder / configure.folder_name(shape)
            configure.configure(name, overrides, config)
            slang, instance = operators.elaborate(config / "ti_config_pkg.sv", ROOT / "rtl", top)
            names = set()
            instance.visit(
                lambda node: (
                    names.add(node.definition.name) if hasattr(node, "definition") else None
                )
            )
            self.built[shape, top] = names
            del slang
        return self.built[shape, top]

    def shape_of(self, module: str) -> str:
        """A configuration that has a module; the first for packages."""
        return next(
            (s for s in switch.SHAPES if module in self.modules(s, "ti_top")), switch.SHAPES[0]
        )

    def draw(self, count: int, seed: int, unit: str) -> dict[int, Mutation]:
        """A sample, by number; of one module, or of all."""
        numbers = [n for n, m in self.numbered.items() if unit in ("", m.module)]
        return {n: self.numbered[n] for n in mutations.sample(numbers, count, seed)}

    def checks(self, mutation: Mutation) -> list[tuple[str, str]]:
        """What a mutation is tried with once lint has taken it, in order, each with its stage."""
        tests = nearest_tests(mutation.module, self.children)
        others = [test for test in faults_of(mutation.file) if test not in tests]
        return [
            *((test, "unit") for test in tests),
            *((run, "lock-step") for run in self.runs(mutation.module)),
            *((test, "above") for test in others),
        ]

    def runs(self, module: str) -> list[str]:
        """The runs in lock-step whose engine has a module (or any, for a package)."""
        names = []
        for name, (overrides, _, _) in LOCK_STEP.items():
            inside = self.modules(f"tiny {overrides}".strip(), "ti_engine")
            if module in inside or module.endswith("_pkg"):
                names.append(name)
        return names


def nearest_tests(module: str, children: dict[str, set[str]]) -> list[str]:
    """Unit tests of a module, or of those nearest above it."""
    above, seen = {module}, set()
    while above:
        tests = [f"test_{m}" for m in sorted(above) if (ROOT / f"tb/unit/test_{m}.py").is_file()]
        if tests:
            return tests
        seen |= above
        above = {m for m, inside in children.items() if inside & above} - seen
    return []


def faults_of(file: str) -> list[str]:
    """Tests that the faults of a file in tb/mutants.yaml name, most often named first."""
    named = [test for fault in mutants.load() if fault.file == file for test in fault.tests]
    return sorted(dict.fromkeys(named), key=lambda test: -named.count(test))


class Tests:
    """What tests are made of, as a digest: what survives them is tried again when it changes."""

    def __init__(self):
        text = hashlib.sha256()
        for folder in TESTS:
            for file in sorted((ROOT / folder).rglob("*")):
                if file.suffix in SUFFIXES and not file.name.startswith("test_"):
                    text.update(file.read_bytes())
        self.shared = text.hexdigest()

    def digest(self, checks: Iterable[str]) -> str:
        """Of unit tests, FILE or FILE::TEST, and runs in lock-step."""
        text = hashlib.sha256(self.shared.encode())
        for check in checks:
            file = ROOT / f"tb/unit/{check.partition('::')[0]}.py"
            text.update(file.read_bytes() if file.is_file() else check.encode())
        return text.hexdigest()[:16]
