# SPDX-License-Identifier: Apache-2.0
"""Longest paths between registers, from the delays that nextpnr writes (SDF, ps).

nextpnr's own report has one path a clock.  Its SDF has every delay of a cell and of a wire, so the
longest arrival at each register follows by one walk; on an ECP5 the first of these paths is the
reported one.  On Gowin parts nextpnr gives no delay to a look-up table that it puts in front of a
register to pass a value, and leaves out all paths through it: here it has the delay of the slowest.
"""

import re
from dataclasses import dataclass
from pathlib import Path

TOKEN = re.compile(
    r'\(CELLTYPE "([^"]*)"\)|\(INSTANCE (\S*)\)'
    r"|\(INTERCONNECT (\S+)/(\S+) (\S+)/(\S+) \([^:]*:[^:]*:(-?\d+)\)"
    r"|\(IOPATH (\S+) (\S+) \([^:]*:[^:]*:(-?\d+)\)"
    r"|\(SETUPHOLD \(posedge (\S+)\) \(\w+ (\S+)\) \([^:]*:[^:]*:(-?\d+)\)"
)

PASSING = re.compile(r"_passthrough_lut\$$")


@dataclass(frozen=True)
class TimedPath:
    """One path: delay with setup, in ns, and the cells at its ends."""

    ns: float
    start: str
    end: str


def plain(name: str) -> str:
    """A name without the escapes of SDF."""
    return name.replace("\\", "")


def longest(sdf: Path, count: int) -> list[TimedPath]:
    """The longest path to each of the `count` registers where they are longest, longest first."""
    wires: dict[tuple, tuple] = {}  # sink: (driver, ps)
    arcs: dict[tuple, list] = {}  # output: [(input, ps)]
    setups: dict[tuple, int] = {}
    clocks: set[tuple] = set()  # pins where paths begin
    kinds: dict[str, str] = {}  # cell type by cell
    slowest: dict[str, int] = {}  # ps by cell type
    kind = instance = ""
    with sdf.open() as lines:
        for line in lines:
            found = TOKEN.search(line)
            if not found:
                continue
            (
                new_kind,
                name,
                d_cell,
                d_pin,
                s_cell,
                s_pin,
                wire,
                i_pin,
                o_pin,
                arc,
                end,
                clock,
                setup,
            ) = found.groups()
            if new_kind:
                kind = new_kind
            elif name is not None:
                instance = plain(name)
                kinds[instance] = kind
            elif d_cell:
                sink = plain(s_cell), plain(s_pin)
                wires[sink] = (plain(d_cell), plain(d_pin)), int(wire)
            elif o_pin:
                source = instance, plain(i_pin)
                arcs.setdefault((instance, plain(o_pin)), []).append((source, int(arc)))
                slowest[kind] = max(slowest.get(kind, 0), int(arc))
            elif end:
                pin = instance, plain(end)
                clocks.add((instance, plain(clock)))
                setups[pin] = max(setups.get(pin, 0), int(setup))

    passing = {c: slowest.get(k, 0) for c, k in kinds.items() if PASSING.search(c)}
    for sink in wires:
        if sink[0] in passing:
            arcs.setdefault((sink[0], "F"), []).append((sink, passing[sink[0]]))

    arrival: dict[tuple, tuple | None] = {}  # output: (ps, cell where the path begins)

    def at_sink(pin):
        driver, ps = wires[pin]
        before = arrival.get(driver)
        return before and (before[0] + ps, before[1])

    def settle(output):
        """Depth first without recursion, for chains of carries are long."""
        stack, entered = [output], set()
        while stack:
            top = stack[-1]
            if top in arrival:
                stack.pop()
                continue
            waits = [
                wires[source][0]
                for source, _ in arcs.get(top, ())
                if source in wires and source not in clocks and wires[source][0] not in arrival
            ]
            if waits and top not in entered:
                entered.add(top)
                stack += waits
                continue
            stack.pop()
            best = None
            for source, ps in arcs.get(top, ()):
                if source in clocks:
                    before = (0, top[0])
                else:
                    before = at_sink(source) if source in wires else None
                if before and (best is None or before[0] + ps > best[0]):
                    best = (before[0] + ps, before[1])
            arrival[top] = best

    found: dict[str, TimedPath] = {}
    for pin, setup in setups.items():
        if pin in wires:
            settle(wires[pin][0])
            last = at_sink(pin)
            cell = pin[0]
            if last and (cell not in found or last[0] + setup > 1000 * found[cell].ns):
                found[cell] = TimedPath((last[0] + setup) / 1000, last[1], cell)
    return sorted(found.values(), key=lambda path: -path.ns)[:count]
