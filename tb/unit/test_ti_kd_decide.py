# SPDX-License-Identifier: Apache-2.0
"""`ti_kd_decide` follows the traversal rules in every combination of what it looks at."""

from collections import deque
from itertools import combinations, product

import cocotb
import pytest
import ti_model
from agents.bench import run
from cocotb.triggers import Timer
from models.numbers import hexed, numbers
from models.payload import parameter

NEAR, FAR, BOTH = range(3)
OK, MEMORY_ERROR, WATCHDOG = 0, 2, 3
ROOT, INDEX, LINK, TOP = 7, 100, 900, 555
MOST_TRIANGLES = 65535
STACK_DEPTH, WATCHDOG_STEPS = parameter("StackDepth", 4), parameter("WatchdogSteps", 50)
RESTART = bool(parameter("Restart", 1))
CULL, GUARD = parameter("IntervalCull", 1), parameter("Guard", 4)
CMP_STAGES = parameter("CmpStages", 0)


def interval():
    """tmin, tmax, the ray's tmax and an entry's tmax."""
    n = numbers()
    return n.of(1.0), n.of(2.0), n.of(5.0), n.of(3.0)


def around(*places):
    """Each place and its neighbours, then infinities, zeros and NaN."""
    n = numbers()
    values = [p + ulp for p in places for ulp in (-1, 0, 1)]
    return [*values, n.of(1.5), 0, n.sign, n.inf, n.inf | n.sign, n.nan]


def common():
    """Sign, reorder flag, entries on the stack, one dropped, steps before this node, error.

    An entry is dropped only where rays restart.
    """
    return product(
        (0, 1),
        (0, 1),
        range(STACK_DEPTH + 1),
        (0, 1) if RESTART else (0,),
        (0, WATCHDOG_STEPS - 1, WATCHDOG_STEPS, WATCHDOG_STEPS + 1),
        (0, 1),
    )


def inner_cases():
    tmin, tmax, ray_tmax, _ = interval()
    for (negative, reorder, level, dropped, steps, error), t in product(
        common(), around(tmin, tmax)
    ):
        if level == STACK_DEPTH and not RESTART:  # nothing is pushed then
            continue
        yield case(negative, reorder, level, dropped, steps, error, t=t, ray_tmax=ray_tmax)


def leaf_cases():
    tmin, tmax, ray_tmax, _ = interval()
    for (negative, reorder, level, dropped, steps, error), tbest, count, whole in product(
        common(), around(tmax), (0, 1, MOST_TRIANGLES, MOST_TRIANGLES + 1), (0, 1)
    ):
        end = tmax if whole else ray_tmax
        yield case(
            negative, reorder, level, dropped, steps, error, count=count, tbest=tbest, ray_tmax=end
        )
    for bit in range(16, 29):
        yield case(0, 0, 0, 0, 0, 0, count=1 << bit, ray_tmax=ray_tmax)
    inf = numbers().inf
    ends = {0, 1, GUARD, GUARD + 1, tmin, inf - GUARD - 1, inf - GUARD, inf - 1, inf}
    for (first, last), tbest in product(combinations(sorted(ends), 2), (inf, tmin)):
        rest = {"count": 1, "tbest": tbest, "tmin": first, "tmax": last, "ray_tmax": last}
        yield case(0, 0, 0, 0, 0, 0, **rest)


def case(negative, reorder, level, dropped, steps, error, **rest):
    tmin, tmax, _, top_tmax = interval()
    leaf = "count" in rest
    link = rest.pop("count", LINK) << 3 | reorder << 2 | (3 if leaf else 1)
    return {
        "root": ROOT,
        "index": INDEX,
        "node": link << 32 | 123,
        "error": error,
        "negative": negative,
        "t": numbers().nan,
        "tmin": tmin,
        "tmax": tmax,
        "tbest": numbers().nan,
        "steps": steps,
        "level": level,
        "dropped": dropped,
        "top_node": TOP,
        "top_tmax": top_tmax,
        **rest,
    }


def expected(c):
    """The outputs that mean something, by the rules of docs/architecture.md."""
    if c["steps"] >= WATCHDOG_STEPS:
        return {"done": 1, "status": WATCHDOG, "go": 0, "leaf": 0, "steps": c["steps"]}
    steps = c["steps"] + 1
    word = c["node"] >> 32
    if c["error"] or (word & 3 == 3 and word >> 3 > MOST_TRIANGLES):
        return {"done": 1, "status": MEMORY_ERROR, "go": 0, "leaf": 0, "steps": steps}
    decide = leaf_rule if word & 3 == 3 else inner_rule
    return {"done": 0, "leaf": 0, "go": 0, "steps": steps, **decide(c, word)}


def inner_rule(c, word):
    n = numbers()
    near, far = ti_model.ordered(word, c["index"], bool(c["negative"]))
    side = n.model("choose", c["t"], c["tmin"], c["tmax"])
    on = {"go": 1, "pop": 0, "restart": 0, "tmin": c["tmin"]}
    if side != BOTH:
        rest = {"next": far if side == FAR else near, "push": 0, "tmax": c["tmax"]}
        return {**on, **rest, "level": c["level"], "dropped": c["dropped"]}
    full = c["level"] == STACK_DEPTH
    return {
        **on,
        "next": near,
        "push": 1,
        "far": far,
        "tmax": c["t"],
        "level": c["level"] + (not full),
        "dropped": int(c["dropped"] or full),
    }


def leaf_rule(c, word):
    n = numbers()
    full = int(word >> 3 != 0)
    best_ends = n.model("fp_le", c["tbest"], c["tmax"])
    ends = {"leaf": full, "done": int(not full), "status": OK, "push": 0}
    if full:
        ends |= {"tnear": 0, "tfar": c["tbest"], "bound": c["tmax"]}
        if CULL:
            ends["tnear"] = max(c["tmin"] - GUARD, 0)
            ends["tfar"] = c["tbest"] if best_ends else min(c["tmax"] + GUARD, n.inf)
    elif best_ends:
        return {**ends, "go": 0}
    on = {**ends, "done": 0, "go": 1, "tmin": c["tmax"]}
    on.pop("status")
    if c["level"]:
        rest = {"next": TOP, "tmax": c["top_tmax"], "level": c["level"] - 1, "pop": 1}
        return {**on, **rest, "dropped": c["dropped"], "restart": 0}
    if c["dropped"] and c["tmax"] != c["ray_tmax"]:
        rest = {"next": ROOT, "tmax": c["ray_tmax"], "level": 0, "pop": 0}
        return {**on, **rest, "dropped": 0, "restart": 1}
    return {**ends, "go": 0}


async def check(dut, cases):
    """A case a cycle, each answered `CmpStages` edges of the clock later."""
    seen = set()
    dut.rst_ni.value = 1
    under_way = deque()
    for c in [*cases, *[None] * CMP_STAGES]:
        dut.clk_i.value = 0
        for name, value in (c or {}).items():
            getattr(dut, f"{name}_i").value = value
        await Timer(1, "ns")
        under_way.append(c)
        if len(under_way) <= CMP_STAGES:
            dut.clk_i.value = 1
            await Timer(1, "ns")
            continue
        c = under_way.popleft()
        want = expected(c)
        got = {name: int(getattr(dut, f"{name}_o").value) for name in want}
        assert got == want, f"{hexed(c)}: want {hexed(want)}, got {hexed(got)}"
        seen.add(tuple(want.get(k, 0) for k in ("go", "leaf", "done", "push", "pop", "restart")))
        dut.clk_i.value = 1
        await Timer(1, "ns")
    return seen


@cocotb.test()
async def an_inner_node_goes_on_with_near_far_or_both(dut):
    seen = await check(dut, inner_cases())

    assert seen == {(0, 0, 1, 0, 0, 0), (1, 0, 0, 0, 0, 0), (1, 0, 0, 1, 0, 0)}


@cocotb.test()
async def a_leaf_goes_on_from_the_stack_or_the_root_or_ends(dut):
    seen = await check(dut, leaf_cases())

    ends = {(0, 0, 1, 0, 0, 0), (0, 1, 0, 0, 0, 0)}
    pops = (0, 1) if STACK_DEPTH else (0,)
    pops = pops if RESTART else (1,)
    goes_on = {(1, leaf, 0, 0, pop, 1 - pop) for leaf in (0, 1) for pop in pops}
    assert seen == ends | goes_on


SHAPES = [
    (0, 1, 1, 4, 0),
    (1, 1, 0, 0, 0),
    (4, 1, 1, 4, 0),
    (4, 1, 1, 0, 0),
    (4, 0, 1, 4, 0),
    (4, 1, 1, 4, 1),
    (2, 0, 0, 4, 1),
]


@pytest.mark.parametrize(("depth", "restart", "cull", "guard", "cmp"), SHAPES)
def test_ti_kd_decide(depth, restart, cull, guard, cmp):
    values = {"StackDepth": depth, "Restart": restart, "IntervalCull": cull, "Guard": guard}
    values["CmpStages"] = cmp
    run("ti_kd_decide", "test_ti_kd_decide", params={"WatchdogSteps": 50, **values})
