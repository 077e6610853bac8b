# SPDX-License-Identifier: Apache-2.0
"""The RTL as slang parses it, not elaborated: where a node stands, and what in it is settled early.

What a tool must know before it builds is *settled*: parameters, ranges, types, conditions of
`generate`, labels of `case`, numbers of copies, heads of loops and functions that any of these
call.  All else is live.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import pyslang
from pyslang.parsing import Token
from pyslang.syntax import SyntaxNode, SyntaxTree

# What is settled before a simulation begins, or is no logic.
FIXED = {
    "ParameterDeclaration", "TypeParameterDeclaration", "ParameterPortList",
    "ParameterValueAssignment", "TypedefDeclaration", "DataDeclaration", "AnsiPortList",
    "FunctionPrototype", "VariableDimension", "ModuleHeader", "PackageHeader",
    "PackageImportDeclaration", "GenvarDeclaration", "InstanceName",
    "SimpleRangeSelect", "EventControlWithExpression", "ImplicitEventControl",
    "ConcurrentAssertionMember", "ImmediateAssertionMember", "AssertPropertyStatement",
    "ImmediateAssertStatement", "ElabSystemTask", "InitialBlock", "AttributeInstance",
    "PostincrementExpression", "PostdecrementExpression",
}  # fmt: skip
# The parts of a node that are not fixed.
LIVE = {
    "IfGenerate": ("block", "elseClause"),
    "LoopGenerate": ("block",),
    "CaseGenerate": ("items",),
    "CastExpression": ("right",),
    "MultipleConcatenationExpression": ("concatenation",),
    "AscendingRangeSelect": ("left",),
    "DescendingRangeSelect": ("left",),
    "StandardCaseItem": ("clause",),
    "ForLoopStatement": ("statement",),
    "AssignmentPatternItem": ("expr",),
    "AssignmentPatternExpression": ("pattern",),
    "ReplicatedAssignmentPattern": ("items",),
}
# System functions whose argument is a value.
OF_VALUES = ("$signed", "$unsigned")
CLOCK_OR_RESET = re.compile(r"(?:^|_)(?:clk|rst|aclk|aresetn)(?:_|$)")


class SyntaxProblem(Exception):
    """One sentence: a file cannot be read."""


class Source:
    """A file and its syntax tree."""

    def __init__(self, root: Path, file: str, folders: Iterable[Path]):
        self.file = file
        self.text = (root / file).read_text()
        self.bytes = self.text.encode()
        self.manager = pyslang.SourceManager()
        for folder in folders:
            self.manager.addUserDirectories(str(folder))
        self.tree = SyntaxTree.fromFile(str(root / file), self.manager)
        for found in self.tree.diagnostics:
            if found.isError():
                line = self.manager.getLineNumber(found.location)
                raise SyntaxProblem(f"{file}:{line}: slang cannot read it: {found.code}")

    def span(self, node) -> tuple[int, int] | None:
        """Where a node stands in the text; None for what a macro or another file writes."""
        span = node.sourceRange
        for place in (span.start, span.end):
            if (
                self.manager.isMacroLoc(place)
                or place.buffer != self.tree.root.sourceRange.start.buffer
            ):
                return None
        return span.start.offset, span.end.offset


def calls(node) -> Iterator[str]:
    """Names of the functions that are called anywhere in a node."""
    for inner in nodes(node):
        if inner.kind.name == "InvocationExpression":
            yield str(inner.left).strip().rpartition("::")[2]


def nodes(node) -> Iterator[SyntaxNode]:
    """A node and all nodes in it."""
    if isinstance(node, Token):
        return
    yield node
    for child in node:
        yield from nodes(child)


def live_parts(node) -> tuple[list, list]:
    """The children of a node that may change, and those that are settled."""
    name = node.kind.name
    children = [child for child in node if not isinstance(child, Token)]
    if name in FIXED:
        return [], children
    if name in LIVE:
        live = [getattr(node, part) for part in LIVE[name]]
    elif name == "InvocationExpression":
        system = node.left.kind.name == "SystemName"
        live = [] if system and str(node.left).strip() not in OF_VALUES else [node.arguments]
    elif name.endswith("AssignmentExpression"):
        live = [node.right]
    else:
        live = children
    live = [part for part in live if part is not None]
    return live, [child for child in children if all(child != part for part in live)]


def settled_calls(node) -> Iterator[str]:
    """Names of functions that are called where the result is settled before a simulation."""
    if isinstance(node, Token):
        return
    live, fixed = live_parts(node)
    for part in fixed:
        yield from calls(part)
    for part in live:
        yield from settled_calls(part)


def settled_functions(trees: list[SyntaxTree]) -> set[str]:
    """Functions that a tool evaluates, with those that they call."""
    inside = {}
    for tree in trees:
        for node in nodes(tree.root):
            if node.kind.name == "FunctionDeclaration":
                name = str(node.prototype.name).strip().rpartition("::")[2]
                inside.setdefault(name, set()).update(calls(node))
    found = {name for tree in trees for name in settled_calls(tree.root)} & inside.keys()
    while more := {name for f in found for name in inside[f]} & inside.keys() - found:
        found |= more
    return found


def input_ports(trees: list[SyntaxTree]) -> dict[str, set[str]]:
    """The inputs of each module, without clocks and resets."""
    ports = {}
    for tree in trees:
        for node in nodes(tree.root):
            if node.kind.name == "ModuleDeclaration":
                mine = ports.setdefault(node.header.name.valueText, set())
                for port in nodes(node.header.ports):
                    if port.kind.name == "ImplicitAnsiPort" and re.match(
                        r"\s*input\b", str(port.header)
                    ):
                        name = port.declarator.name.valueText
                        if not CLOCK_OR_RESET.search(name):
                            mine.add(name)
    return ports


def vectors(module) -> Iterator[str]:
    """Names of a module that are declared with one range of bits, so mostly several bits wide."""
    for node in nodes(module):
        if node.kind.name != "DataDeclaration" or node.type.kind.name != "LogicType":
            continue
        if len(node.type.dimensions) == 1:
            for declarator in node.declarators:
                if not isinstance(declarator, Token) and len(declarator.dimensions) == 0:
                    yield declarator.name.valueText


def design(root: Path) -> tuple[list[str], list[Path]]:
    """Files of rtl/ti.f whose changes are of use, and the folders of their headers."""
    words = (root / "rtl/ti.f").read_text().split()
    folders = [root / word.removeprefix("+incdir+") for word in words if word.startswith("+")]
    return [w for w in words if w.startswith("rtl/")], folders


def instances(root: Path, files: list[str], folders: Iterable[Path]) -> dict[str, set[str]]:
    """The modules that each module has instances of, in any of its shapes."""
    inside = {}
    for file in files:
        for node in nodes(Source(root, file, folders).tree.root):
            if node.kind.name == "ModuleDeclaration":
                inside[node.header.name.valueText] = {
                    inner.type.valueText
                    for inner in nodes(node)
                    if inner.kind.name == "HierarchyInstantiation"
                }
    return inside
