# SPDX-License-Identifier: Apache-2.0
"""The table of scripts/mutation_score.py, with what tb/survivors.yaml says of what survives."""

import json
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

import yaml
from mutations import KINDS, Mutation

EXPLANATIONS = Path(__file__).resolve().parents[1] / "tb/survivors.yaml"
STAGES = ("lint", "unit", "lock-step", "above")


class ExplanationError(Exception):
    """One sentence: tb/survivors.yaml is wrong."""


@dataclass(frozen=True)
class Explanation:
    """Why no test finds a mutation; `equivalent` when nobody could see it.

    The mutation is the one of `file` that makes `new` of `old` in the line `at`, whatever the
    spaces.
    """

    file: str
    at: str
    old: str
    new: str
    why: str
    equivalent: bool

    def key(self) -> tuple[str, ...]:
        return tuple(" ".join(word.split()) for word in (self.file, self.at, self.old, self.new))


def load(path: Path = EXPLANATIONS) -> dict[tuple[str, ...], Explanation]:
    """The explanations, by the keys of their mutations."""
    explanations = {}
    for entry in yaml.safe_load(path.read_text()) or []:
        try:
            explanation = Explanation(**entry)
        except TypeError as error:
            raise ExplanationError(f"{path}: {entry}: {error}") from None
        if explanation.key() in explanations:
            raise ExplanationError(f"{path}: {entry} stands twice")
        explanations[explanation.key()] = explanation
    return explanations


def rows(of: list[tuple[str, str]]) -> list[tuple]:
    """Lines of a table: name, how many, found by each stage, surviving, equivalent, score."""
    names = list(dict.fromkeys(name for name, _ in of))
    table = []
    for name in (*names, "all"):
        mine = Counter(how for which, how in of if name in (which, "all"))
        found = sum(mine[stage] for stage in STAGES)
        total = sum(mine.values())
        judged = total - mine["equivalent"]
        score = f"{100 * found / judged:.1f} %" if judged else "-"
        stages = [mine[stage] for stage in STAGES]
        table.append((name, total, *stages, mine["survives"], mine["equivalent"], score))
    return table


def print_rows(heading: str, table: list[tuple]) -> None:
    columns = (heading, "tried", *STAGES, "survive", "equivalent", "score")
    for row in (columns, *table):
        print(f"{row[0]:22}" + "".join(f"{cell:>11}" for cell in row[1:]))
    print()


def report(design, sample: dict[int, Mutation], outcomes: dict, file: Path | None) -> int:
    """Print who found what, and write it; the exit status."""
    explanations = load()
    hows, unexplained, survivors = {}, 0, []
    for number, mutation in sample.items():
        outcome = outcomes[number]
        explanation = explanations.get(mutation.key())
        how = outcome.by or ("equivalent" if explanation and explanation.equivalent else "survives")
        hows[number] = how
        if not outcome.by:
            survivors.append((mutation, explanation))
            unexplained += not explanation
    by_kind = [(sample[n].kind, how) for n, how in hows.items()]
    by_kind.sort(key=lambda row: KINDS.index(row[0]))
    by_module = [(sample[n].module, how) for n, how in hows.items()]
    tables = {"kind": rows(by_kind), "module": rows(by_module)}
    print()
    for heading, table in tables.items():
        print_rows(heading, table)
    for mutation, explanation in survivors:
        words = [" ".join(text.split()) for text in (mutation.old, mutation.new)]
        print(f"{mutation.file}:{mutation.line}: {mutation.kind}: {words[0]}  ->  {words[1]}")
        if explanation:
            equivalent = "equivalent, " if explanation.equivalent else ""
            print(f"    {equivalent}{explanation.why}")
        else:
            print(f"    not explained; in line: {mutation.at}")
    if file:
        file.parent.mkdir(parents=True, exist_ok=True)
        results = [
            {**asdict(outcomes[n]), "how": hows[n], **asdict(mutation)}
            for n, mutation in sample.items()
        ]
        summary = {"all": design.all, "compile": len(design.numbered), **tables, "results": results}
        file.write_text(json.dumps(summary, indent=1) + "\n")
    return 1 if unexplained else 0
