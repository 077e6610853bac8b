# SPDX-License-Identifier: Apache-2.0
"""Small changes of the RTL, found in its syntax.

A change is a `Mutation`: what stands at a place of a file, and what it becomes.  `find` reads files
and gives all of them in order.

What a tool must know before it builds is left alone (scripts/rtl_syntax.py), and so are clocks,
left sides, assertions and what a macro writes.
"""

import random
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pyslang.parsing import Token
from rtl_syntax import Source, input_ports, live_parts, nodes, settled_functions, vectors

# A zero as one writes it, and one that changes neither width nor sign of what it stands beside.
ZERO, NEUTRAL_ZERO = "'0", "1'sb0"

KINDS = ("operator", "constant", "condition", "assignment", "reset", "width", "port")

# Operators by kind of node: those that take their place.  Operands and the type stay as they are.
BINARY = {
    "AddExpression": ["-"],
    "SubtractExpression": ["+"],
    "BinaryAndExpression": ["|"],
    "BinaryOrExpression": ["&"],
    "BinaryXorExpression": ["&"],
    "BinaryXnorExpression": ["^"],
    "LogicalAndExpression": ["||"],
    "LogicalOrExpression": ["&&"],
    "EqualityExpression": ["!="],
    "InequalityExpression": ["=="],
    "LessThanExpression": ["<=", ">="],
    "LessThanEqualExpression": ["<", ">"],
    "GreaterThanExpression": [">=", "<="],
    "GreaterThanEqualExpression": [">", "<"],
    "LogicalShiftLeftExpression": [">>"],
    "LogicalShiftRightExpression": ["<<"],
    "ArithmeticShiftRightExpression": [">>"],
}
UNARY = {
    "UnaryLogicalNotExpression": "!!",
    "UnaryBitwiseNotExpression": "",
    "UnaryMinusExpression": "",
    "UnaryBitwiseAndExpression": "|",
    "UnaryBitwiseOrExpression": "&",
}
LITERALS = (
    "IntegerLiteralExpression",
    "IntegerVectorExpression",
    "UnbasedUnsizedLiteralExpression",
)
# Negating one of these is a change of its operator.
NEGATED_ALREADY = (*BINARY.keys() - {"LogicalAndExpression", "LogicalOrExpression"}, *UNARY)

RESET = re.compile(r"!\s*(?:\w+_)?rst_\w+")


@dataclass(frozen=True)
class Mutation:
    """`old` at `start` of `file` becomes `new`.

    `value` is what an expression becomes, in `new` with `before` and `after` around it; None for a
    statement that is dropped.  `at` is the line that it begins in, without indent.
    """

    file: str
    module: str
    kind: str
    start: int
    old: str
    new: str
    value: str | None
    before: str
    line: int
    at: str

    @property
    def end(self) -> int:
        return self.start + len(self.old)

    @property
    def after(self) -> str:
        return ")" if self.before else ""

    @property
    def switched(self) -> str:
        """`value` where it stands beside what it takes the place of."""
        return (
            NEUTRAL_ZERO
            if self.value == ZERO and self.kind in ("assignment", "port")
            else self.value
        )

    def apply(self, text: str) -> str:
        """The text of the file with this change alone."""
        return text[: self.start] + self.new + text[self.end :]

    def key(self) -> tuple[str, ...]:
        """What stays the same when lines move: file, line, old and new text, by words."""
        return tuple(" ".join(word.split()) for word in (self.file, self.at, self.old, self.new))


def sample(of: list[int], count: int, seed: int) -> list[int]:
    """`count` of them (all, when there are no more), by the seed alone.

    The first ones of a larger sample are a smaller one, and a fair one.
    """
    order = sorted(of)
    random.Random(seed).shuffle(order)
    return order[:count]


class Finder:
    """The mutations of one file."""

    def __init__(self, source: Source, settled: set[str], inputs: dict[str, set[str]]):
        self.source, self.settled, self.inputs = source, settled, inputs
        self.found: list[Mutation] = []
        self.module = ""
        self.vectors: set[str] = set()

    def find(self) -> list[Mutation]:
        self.walk(self.source.tree.root, False)
        return sorted(self.found, key=lambda m: (m.start, -m.end))

    def add(self, node, kind: str, values: Iterable[str | None], before: str = "") -> None:
        """A change of `node` into each of `values`; None drops it."""
        span = self.source.span(node)
        if not span:
            return
        begin, end = (len(self.source.bytes[:place].decode()) for place in span)
        old = self.source.text[begin:end]
        line_begin = self.source.text.rfind("\n", 0, begin) + 1
        for value in values:
            new = ";" if value is None else f"{before}{value})" if before else value
            if kind == "operator" and inside_an_operation(node):
                new = f"({new})"
            self.found.append(
                Mutation(
                    file=self.source.file,
                    module=self.module,
                    kind=kind,
                    start=begin,
                    old=old,
                    new=new,
                    value=value,
                    before=before,
                    line=self.source.text.count("\n", 0, begin) + 1,
                    at=self.source.text[line_begin:].partition("\n")[0].strip(),
                )
            )

    def slice(self, node) -> str:
        """The text of a node; empty when a macro has a part in it."""
        span = self.source.span(node)
        return self.source.bytes[slice(*span)].decode() if span else ""

    def walk(self, node, in_reset: bool) -> None:
        if node is None or isinstance(node, Token):
            return
        name = node.kind.name
        if name in ("ModuleDeclaration", "PackageDeclaration"):
            self.module = node.header.name.valueText
            self.vectors = set(vectors(node))
        elif name == "FunctionDeclaration":
            if str(node.prototype.name).strip() in self.settled:
                return
        elif name == "ConditionalStatement":
            self.conditional(node, in_reset)
            return
        elif name == "HierarchyInstantiation":
            inputs = self.inputs.get(node.type.valueText, set())
            for port in nodes(node):
                if port.kind.name == "NamedPortConnection" and port.name.valueText in inputs:
                    self.connection(port)
                    self.walk(port.expr, in_reset)
            return
        if name.endswith("AssignmentExpression") and str(node.left).strip().startswith("unused"):
            return
        self.change(node, name, in_reset)
        for part in live_parts(node)[0]:
            self.walk(part, in_reset)

    def conditional(self, node, in_reset: bool) -> None:
        """`if`: its condition, then both branches, of which the first may be a reset."""
        resets = bool(RESET.fullmatch(str(node.predicate).strip()))
        if resets:
            self.add(node.predicate, "reset", ["1'b0"])
        else:
            self.condition(node.predicate)
            self.walk(node.predicate, in_reset)
        self.walk(node.statement, in_reset or resets)
        if node.elseClause:
            self.walk(node.elseClause, in_reset)

    def condition(self, predicate) -> None:
        text = self.slice(predicate)
        if len(predicate.conditions) != 1 or not text:
            return
        bare = predicate.conditions[0].expr
        while bare.kind.name == "ParenthesizedExpression":
            bare = bare.expression
        negated = [] if bare.kind.name in NEGATED_ALREADY else [f"!({text})"]
        self.add(predicate, "condition", [*negated, "1'b1", "1'b0"])

    def change(self, node, name: str, in_reset: bool) -> None:
        """The changes of a node itself."""
        if name in BINARY:
            left, right = self.slice(node.left), self.slice(node.right)
            if left and right:
                self.add(node, "operator", [f"{left} {new} {right}" for new in BINARY[name]])
        elif name in UNARY:
            if operand := self.slice(node.operand):
                self.add(node, "operator", [f"{UNARY[name]}{operand}"])
        elif name in LITERALS:
            if new := other_number(self.slice(node)):
                self.add(node, "reset" if in_reset else "constant", [new])
        elif name == "ConditionalExpression":
            self.condition(node.predicate)
        elif name == "ExpressionStatement" and node.expr.kind.name.endswith("AssignmentExpression"):
            self.add(node, "reset" if in_reset else "assignment", [None])
        elif name in ("AssignmentExpression", "NonblockingAssignmentExpression"):
            self.assignment(node, in_reset)

    def assignment(self, node, in_reset: bool) -> None:
        right = self.slice(node.right)
        if node.right.kind.name in LITERALS or not right or in_reset:
            return
        self.add(node.right, "assignment", [ZERO])
        if self.slice(node.left) in self.vectors:  # all of it
            self.add(node.right, "width", [f"((({right}) << 1) >> 1)"])

    def connection(self, port) -> None:
        if port.expr is None and not port.openParen:  # `.name`
            name = port.name.valueText
            self.add(port, "port", [ZERO, f"~{name}"], before=f".{name}(")
        elif port.expr is not None and (text := self.slice(port.expr)):
            literal = re.fullmatch(r"[\w']+", text) and not re.match(r"[A-Za-z_]", text)
            if not literal:
                self.add(port.expr, "port", [ZERO, f"~({text})"])


def inside_an_operation(node) -> bool:
    """Whether the node above binds its operands as strongly as its operator says."""
    above = node.parent.kind.name
    return above.endswith("Expression") and not re.search("Parenthesized|Assignment|Concat", above)


def other_number(text: str) -> str:
    """The number after that of a literal, of the same width; empty for one that has none.

    0 and 1 become each other, as does the greatest number 0.
    """
    if match := re.fullmatch(r"'([01])", text):
        return "'1" if match[1] == "0" else "'0"
    if re.fullmatch(r"\d+", text):
        return {"0": "1", "1": "0"}.get(text) or str(int(text) + 1)
    match = re.fullmatch(r"(\d+)\s*'(s?)([bdh])\s*([0-9a-f_]+)", text.lower())
    if not match:
        return ""
    width, sign, base, digits = int(match[1]), match[2], match[3], match[4].replace("_", "")
    value = int(digits, {"b": 2, "d": 10, "h": 16}[base])
    value = {0: 1, 1: 0}.get(value, (value + 1) % 2**width)
    return f"{width}'{sign}{base}{value:{'x' if base == 'h' else base}}"


def find(root: Path, files: list[str], folders: Iterable[Path], left_out=()) -> list[Mutation]:
    """All mutations of `files`, in order; those of `left_out` are read and not changed."""
    folders = list(folders)
    sources = [Source(root, file, folders) for file in files]
    trees = [source.tree for source in sources]
    settled, inputs = settled_functions(trees), input_ports(trees)
    return [
        mutation
        for source in sources
        if source.file not in left_out
        for mutation in Finder(source, settled, inputs).find()
    ]
