# SPDX-License-Identifier: Apache-2.0
"""`ti_memory` reads what a unit asks for once, answers only that unit and starves none.

With L2s it reads a line once for all units of a kind.
"""

from collections import Counter

import cocotb
import pytest
from agents.axi_memory import AxiMemory
from agents.bench import only_if, run, start
from agents.events import Events
from agents.line_ports import LinePorts
from agents.memory import line_data
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import configuration, payloads

REQUEST_CYCLES = 3  # 1 each in `ti_lines`, among the kinds, in `ti_axi_read`
KINDS = ("num_trv", "num_list", "num_ist1")
FOR_EVER = 1_000_000
CONFIG = configuration() if hasattr(cocotb, "top") else {f"{k[4:]}_l2_bytes": 0 for k in KINDS}
L2_KINDS = [kind for kind, key in enumerate(KINDS) if CONFIG[f"{key[4:]}_l2_bytes"]]


class Memory:
    """A unit after reset with units before it and an AXI4 slave behind it."""

    def __init__(self, dut, rng):
        self._dut = dut
        self._line_bytes = configuration()["line_bytes"]
        self.axi = AxiMemory(dut, rng, stalls=True)
        self.units = LinePorts(dut, rng)
        self.bad = self.units.bad = lambda line: False
        self.axi.line = self._line
        self.kind_of = [k for k, key in enumerate(KINDS) for _ in range(configuration()[key])]
        self.lines = self.errors = self.strays = 0  # events
        assert self.units.num == len(self.kind_of)
        for unit, kind in enumerate(self.kind_of):
            if kind in L2_KINDS:  # it knows the ids of the rows that its units have
                self.units.set_ids(unit, configuration()[f"{KINDS[kind][4:]}_rows"])
        banks = {kind: configuration()[f"{KINDS[kind][4:]}_l2_banks"] for kind in L2_KINDS}
        self.bank_kinds = [kind for kind, count in banks.items() for _ in range(count)]
        self.banks = [Events(dut, "l2", dut.l2_events_o[b]) for b in range(len(self.bank_kinds))]
        self._banks_before = [bank.counts() for bank in self.banks]
        self.units.see = self._see_idle
        cocotb.start_soon(self._watch())

    def _line(self, address):
        line = address // self._line_bytes
        return None if self.units.bad(line) else line_data(line, self._line_bytes)

    def asked(self):
        """(unit, line) of the reads of the port, in their order."""
        lines = [address // self._line_bytes for address in self.axi.addresses]
        return [(self.units.unit_of[line], line) for line in lines]

    def in_the_l2s(self):
        """Requests on their way to an L2 or in it."""
        asking = self.units.asking()
        return sum(self.kind_of[unit] in L2_KINDS for unit in asking)

    def _see_idle(self):
        assert (self._dut.idle_o.value == 1) == (self.in_the_l2s() == 0)

    def l2_counts(self, kind):
        """Events of the L2 of a kind since the start, over its banks."""
        counts = Counter()
        banks = zip(self.bank_kinds, self.banks, self._banks_before, strict=True)
        for of, bank, before in banks:
            counts.update(bank.since(before) if of == kind else {})
        return counts

    async def _watch(self):
        while True:
            await ReadOnly()
            if self._dut.rst_ni.value == 1:
                events = payloads().unpack("axi_events_t", int(self._dut.events_o.value))
                self.lines += events["lines"]
                self.errors += events["errors"]
                self.strays += events["strays"]
            await RisingEdge(self._dut.clk_i)


async def begin(dut):
    for name in ("arready", "rvalid", "rid", "rdata", "rresp", "rlast"):
        getattr(dut, f"m_axi_{name}").value = 0
    rng = await start(dut)
    return rng, Memory(dut, rng)


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.7], p_arready=[0.3, 1.0], p_stall=[0.0, 0.3], most=[1, 50])
async def every_port_gets_its_own_answers(dut, p_gap, p_arready, p_stall, most):
    rng, memory = await begin(dut)
    units = memory.units
    memory.axi.ready = lambda: rng.random() < p_arready
    memory.axi.latency = lambda: rng.randint(1, most)
    units.gap = lambda: rng.random() < p_gap
    units.ready = lambda unit: rng.random() >= p_stall
    units.left = [100] * units.num

    await units.play()

    assert units.answered == [100] * units.num
    assert memory.lines == 100 * units.num and memory.errors == memory.strays == 0
    for unit in range(units.num):  # each asked for once; without an L2, in the order of the unit
        asked, taken = (
            [one for one in of if one[0] == unit] for of in (memory.asked(), units.taken)
        )
        if memory.kind_of[unit] in L2_KINDS:
            asked, taken = sorted(asked), sorted(taken)
        assert asked == taken


@cocotb.test()
@cocotb.parametrize(kind=range(len(KINDS)))
async def a_kind_alone_is_answered(dut, kind):
    _, memory = await begin(dut)
    units = memory.units
    units.left = [20 if of == kind else 0 for of in memory.kind_of]
    want = list(units.left)

    await units.play()

    assert units.answered == want


@cocotb.test()
@cocotb.parametrize(p_stall=[0.0, 0.3])
async def errors_reach_only_their_line(dut, p_stall):
    rng, memory = await begin(dut)
    units = memory.units
    units.bad = lambda line: line % 3 == 0
    memory.axi.latency = lambda: rng.randint(1, 30)
    units.ready = lambda unit: rng.random() >= p_stall
    units.left = [60] * units.num

    await units.play()  # it checks each answer

    bad = sum(units.bad(line) for _, line in units.taken)
    assert units.errors == memory.errors == bad > 0


# The time in an L2 is longer than a unit has ids for.
@only_if(not L2_KINDS)
async def kinds_and_units_are_served_in_turn_under_full_load(dut):
    """A kind has its share whatever the number of its units, a unit its share of that."""
    _, memory = await begin(dut)
    units = memory.units
    memory.axi.latency = lambda: 1
    units.left = [200] * units.num
    playing = cocotb.start_soon(units.play())
    while all(units.left):
        await RisingEdge(dut.clk_i)
    served = [unit for unit, _ in memory.asked()]
    await playing

    kinds = [memory.kind_of[unit] for unit in served]
    start_up = 12
    assert len(served) > 300
    for at in range(start_up, len(kinds) - len(KINDS)):
        assert sorted(kinds[at : at + len(KINDS)]) == list(range(len(KINDS))), f"from {at}"
    for kind in range(len(KINDS)):
        mine = [unit for unit in served if memory.kind_of[unit] == kind][start_up:]
        num = memory.kind_of.count(kind)
        for at in range(len(mine) - num):
            assert len(set(mine[at : at + num])) == num, f"kind {kind}, from {at}"


# Others pass a unit that waits for a bank.
@only_if(not L2_KINDS)
@cocotb.parametrize(p_gap=[0.0, 0.5], p_arready=[0.3, 1.0])
async def starves_no_unit(dut, p_gap, p_arready):
    rng, memory = await begin(dut)
    units = memory.units
    memory.axi.ready = lambda: rng.random() < p_arready
    memory.axi.latency = lambda: rng.randint(1, 20)
    units.gap = lambda: rng.random() < p_gap
    units.left = [100] * units.num

    await units.play()

    # Each other unit of the kind once, each time with a turn of every kind, and what queues hold.
    most = max(memory.kind_of.count(kind) for kind in range(len(KINDS)))
    assert max(units.passed) <= len(KINDS) * (most + 2)


@only_if(not L2_KINDS)
async def moves_one_line_a_cycle_each_way(dut):
    _, memory = await begin(dut)
    units = memory.units
    memory.axi.latency = lambda: 1
    units.left = [200] * units.num

    await units.play()

    first, last = units.answered_at[0], units.answered_at[-1]
    assert first - units.taken_at[0] == REQUEST_CYCLES + 1 + 1  # memory 1, answer 1
    middle = [at for at in units.answered_at if at < first + 400]
    assert len(middle) == 400 and last > first + 400, "one answer a cycle while all ask"


@only_if(not L2_KINDS)
async def holds_max_reads_and_recovers(dut):
    _, memory = await begin(dut)
    units, cap = memory.units, configuration()["max_reads"]
    memory.axi.latency = lambda: FOR_EVER
    units.left = [cap] * units.num
    playing = cocotb.start_soon(units.play())
    await ClockCycles(dut.clk_i, 100)
    assert memory.axi.in_flight() == memory.lines == cap

    memory.axi.latency = lambda: 3
    memory.axi._waiting = [(0, *entry[1:]) for entry in memory.axi._waiting]
    await playing
    assert units.answered == [cap] * units.num


@cocotb.test()
async def second_answers_reach_nobody(dut):
    rng, memory = await begin(dut)
    units = memory.units
    memory.axi.latency = lambda: rng.randint(1, 20)
    memory.axi.repeat = lambda: rng.random() < 0.5
    units.left = [60] * units.num

    await units.play()

    assert units.answered == [60] * units.num
    assert memory.strays == memory.axi.strays > 50


@only_if(L2_KINDS)
@cocotb.parametrize(p_stall=[0.0, 0.4])
async def units_of_a_kind_with_an_l2_share_lines(dut, p_stall):
    rng, memory = await begin(dut)
    units = memory.units
    memory.axi.latency = lambda: rng.randint(1, 30)
    units.ready = lambda unit: rng.random() >= p_stall
    # Each kind in lines of its own, few enough for its L2.
    units.line = lambda unit: 16 * memory.kind_of[unit] + rng.randrange(8)
    units.left = [60] * units.num

    await units.play()

    assert units.answered == [60] * units.num
    asked = Counter(address // configuration()["line_bytes"] for address in memory.axi.addresses)
    for kind in L2_KINDS:
        taken = 60 * memory.kind_of.count(kind)
        counts = memory.l2_counts(kind)
        assert {asked[16 * kind + i] for i in range(8)} == {1}
        assert counts["misses"] == 8 and counts["accesses"] == taken
        assert counts["hits"] + counts["merged"] == taken - 8
    for kind in set(range(len(KINDS))) - set(L2_KINDS):
        assert sum(asked[16 * kind + i] for i in range(8)) == 60 * memory.kind_of.count(kind)


@only_if(L2_KINDS)
async def a_hit_in_an_l2_takes_exactly_its_latency(dut):
    _, memory = await begin(dut)
    units = memory.units
    units.line = lambda unit: 5
    for unit, kind in enumerate(memory.kind_of):
        for _ in range(2):
            units.left[unit] = 1
            await units.play()
        cycles = units.requests[-1].answered - units.requests[-1].taken
        assert (cycles == configuration()["l2_latency"]) == (kind in L2_KINDS)


@only_if(L2_KINDS)
async def a_miss_in_an_l2_passes_the_port_on_its_way(dut):
    _, memory = await begin(dut)
    units = memory.units
    memory.axi.latency = lambda: 1
    unit = memory.kind_of.index(L2_KINDS[0])
    units.left[unit] = 1
    await units.play()

    cycles = units.requests[0].answered - units.requests[0].taken
    # Tags 1 and the queue of line requests 1 in place of the last 2 of a hit; memory 1, answer 1;
    # and 2 from the line to its unit.
    assert cycles == configuration()["l2_latency"] + REQUEST_CYCLES + 1 + 1 + 2


@only_if(L2_KINDS)
async def forgets_every_line_on_flush(dut):
    _, memory = await begin(dut)
    units = memory.units
    units.line = lambda unit: 100 * unit + len(units.taken) % 8
    for again in range(1, 4):
        before = len(units.taken)
        for unit in range(units.num):  # eight lines of its own, over all banks
            units.left = [8 * (u == unit) for u in range(units.num)]
            await units.play()
        assert len(units.taken) == before + 8 * units.num
        assert len(memory.axi.addresses) == 8 * units.num * again
        dut.flush_i.value = 1
        await RisingEdge(dut.clk_i)
        dut.flush_i.value = 0


L2 = "{0}_l2_bytes={1} {0}_l2_ways=2 {0}_l2_banks={2} {0}_l2_rows={3}"
SEVERAL = "num_trv=3 num_list=2 num_ist1=2 trv_rows=8 max_reads=32"
ALL = " ".join(
    L2.format(*values)
    for values in [("trv", 8192, 4, 4), ("list", 4096, 1, 2), ("ist1", 4096, 2, 16)]
)
SHAPES = {
    "tiny": "max_reads=4",
    "several": SEVERAL,
    "l2 of one kind": f"{SEVERAL} {L2.format('list', 4096, 2, 3)} l2_latency=4",
    "l2 of all kinds": f"{SEVERAL} {ALL}",
}


@pytest.mark.parametrize("shape", SHAPES)
def test_ti_memory(shape):
    run("ti_memory", "test_ti_memory", config=f"tiny {SHAPES[shape]}")
