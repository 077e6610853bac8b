# SPDX-License-Identifier: Apache-2.0
"""`ti_ist1_egress` brings each result out once, in order by kind, and no kind starves."""

from collections import deque

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.stream import Sink
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge
from models.payload import payloads

KINDS = ("inside", "miss", "failed")
FIELDS = ("prim", "values")
OUTPUTS = {"inside": "candidate", "miss": "return", "failed": "return"}
VALUES = ("det", "dett", "detu", "detv")  # from the highest bits on


def candidate(home, values):
    width = payloads().width("fp_t")
    parts = {k: values["values"] >> width * i for i, k in enumerate(reversed(VALUES))}
    parts = {k: part & ((1 << width) - 1) for k, part in parts.items()}
    rest = {k: values[k] for k in ("miss", "prim")}
    return payloads().pack("candidate_t", {**parts, **rest}, home=home)


class Passes:
    """The rest of an IST1 around the unit: takes slots, gives results, sees slots come back.

    `kinds` says of each test in turn what becomes of it.  `takes()` is whether a slot is taken in a
    cycle, `finishes()` whether a result of the pipeline comes; an error comes beside it.
    `given` lists the kinds of the slots as they came back, `waited` the most results of other
    kinds that the head of each kind saw go before it while its output had room.
    """

    def __init__(self, dut, rng, kinds, takes=lambda: True, finishes=lambda: True):
        self._dut, self._rng = dut, rng
        self._todo = deque(kinds)
        self._takes, self._finishes = takes, finishes
        self._free = list(range(int(dut.NumSlots.value)))
        self._inside = {kind: deque() for kind in KINDS}  # tests in the passes
        self._queues = {kind: deque() for kind in KINDS}  # slots whose results wait
        self._passed = dict.fromkeys(KINDS, 0)
        self._held = {"candidate": 0, "return": 0}  # results in an output
        self.sent = {kind: [] for kind in KINDS}  # what must come out
        self.given, self.waited = [], dict.fromkeys(KINDS, 0)
        cocotb.start_soon(self._run())

    def done(self):
        return not self._todo and len(self._free) == int(self._dut.NumSlots.value)

    async def _run(self):
        while True:
            taken = self._drive_take()
            results = self._drive_results()
            await ReadOnly()
            self._see_give()
            await RisingEdge(self._dut.clk_i)
            if taken:
                kind, test = taken
                self._inside[kind].append(test)
            for kind, slot in results:
                self._queues[kind].append(slot)

    def _drive_take(self):
        dut, rng = self._dut, self._rng
        takes = bool(self._todo and self._free) and self._takes()
        dut.take_i.value = int(takes)
        if not takes:
            return None
        slot = self._free.pop(rng.randrange(len(self._free)))
        home = {"trv": rng.getrandbits(1), "slot": rng.getrandbits(3)}
        dut.take_slot_i.value, dut.take_home_i.value = slot, payloads().pack("home_t", home)
        return self._todo.popleft(), (slot, home)

    def _drive_results(self):
        dut, rng, results = self._dut, self._rng, []
        for kind in KINDS:
            getattr(dut, f"{kind}_i").value = 0
        ready = [kind for kind in ("inside", "miss") if self._inside[kind]]
        if ready and self._finishes():
            kind = rng.choice(ready)
            slot, home = self._inside[kind].popleft()
            values = {k: rng.getrandbits(len(getattr(dut, f"{k}_i"))) for k in FIELDS}
            dut.result_slot_i.value = slot
            for k, value in values.items():
                getattr(dut, f"{k}_i").value = value
            results.append((kind, slot))
            dut.inside_miss_i.value = values["miss"] = rng.getrandbits(1)
            if kind == "inside":
                self.sent[kind].append(candidate(home, values))
            else:
                self.sent[kind].append(payloads().pack("return_t", home=home, count=1))
        if self._inside["failed"] and self._finishes():
            slot, home = self._inside["failed"].popleft()
            dut.failed_slot_i.value = slot
            results.append(("failed", slot))
            self.sent["failed"].append(payloads().pack("return_t", home=home, count=1, error=1))
        for kind, _ in results:
            getattr(dut, f"{kind}_i").value = 1
        return results

    def _see_room(self):
        """Outputs that can take a result: a stage also while it is read, a queue of two not."""
        dut, room = self._dut, {}
        for output, held in self._held.items():
            valid = getattr(dut, f"{output}_valid_o").value == 1
            assert valid == (held > 0)
            read = valid and getattr(dut, f"{output}_ready_i").value == 1
            room[output] = held < 2 if int(dut.Queued.value) else held == 0 or read
            self._held[output] -= read
        return room

    def _see_give(self):
        dut = self._dut
        room = self._see_room()
        ready = {kind for kind in KINDS if self._queues[kind] and room[OUTPUTS[kind]]}
        assert dut.give_o.value == bool(ready), f"{ready} could go"
        if not ready:
            return
        slot = int(dut.give_slot_o.value)
        kind = next((k for k in ready if self._queues[k][0] == slot), None)
        assert kind is not None, f"slot {slot} came back, which is not the next of {ready}"
        self._queues[kind].popleft()
        self._held[OUTPUTS[kind]] += 1
        self._free.append(slot)
        self.given.append(kind)
        self._passed[kind] = 0
        for other in ready - {kind}:
            self._passed[other] += 1
            self.waited[other] = max(self.waited[other], self._passed[other])


async def receive_all(dut, tests, ready=lambda: 1):
    """Take what comes until all slots are back; (candidates, tokens) in their order."""
    got = {"candidate": [], "return": []}

    async def take(name):
        sink = Sink(dut, name)
        while True:
            got[name] += await sink.receive(1, ready, patience=2000)

    tasks = [cocotb.start_soon(take(name)) for name in got]
    for _ in range(20_000):
        if tests.done():
            break
        await RisingEdge(dut.clk_i)
    assert tests.done(), "a slot did not come back"
    await ClockCycles(dut.clk_i, 30)
    for task in tasks:
        task.cancel()
    return got["candidate"], got["return"]


def check(tests, candidates, tokens):
    assert candidates == tests.sent["inside"]
    failed = [payloads().unpack("return_t", bits)["error"] for bits in tokens]
    assert [t for t, f in zip(tokens, failed, strict=True) if not f] == tests.sent["miss"]
    assert [t for t, f in zip(tokens, failed, strict=True) if f] == tests.sent["failed"]


@cocotb.test()
@cocotb.parametrize(p_ready=[1.0, 0.3], p_take=[1.0, 0.4], p_finish=[1.0, 0.4])
async def brings_every_result_out_once(dut, p_ready, p_take, p_finish):
    rng = await start(dut)
    kinds = [rng.choice(KINDS) for _ in range(600)]
    tests = Passes(dut, rng, kinds, lambda: rng.random() < p_take, lambda: rng.random() < p_finish)

    check(tests, *await receive_all(dut, tests, lambda: rng.random() < p_ready))

    assert sorted(tests.given) == sorted(kinds)
    check_waits(tests)


def check_waits(tests):
    """A candidate goes after at most one token, a token after at most three others."""
    most = {"inside": 1, "miss": 3, "failed": 3}
    assert all(tests.waited[kind] <= most[kind] for kind in KINDS), tests.waited


@cocotb.test()
@cocotb.parametrize(every=[1, 2, 3])
async def no_kind_starves(dut, every):
    """Slots come back as fast as they can, so results of all kinds wait for each other;
    an output takes one in `every` cycles."""
    rng = await start(dut)
    batch = int(dut.NumSlots.value)
    filled = [False]
    tests = Passes(dut, rng, list(KINDS) * 200, finishes=lambda: filled[0] or rng.random() < 0.02)
    await ClockCycles(dut.clk_i, 2 * batch)
    filled[0] = True

    check(tests, *await receive_all(dut, tests, lambda: cycle() % every == 0))

    check_waits(tests)
    assert sum(tests.waited.values()) > 2, "nothing had to wait"


@cocotb.test()
@cocotb.parametrize(stuck=["candidate", "return"])
async def one_output_that_waits_does_not_hold_up_the_other(dut, stuck):
    rng = await start(dut)
    free = "return" if stuck == "candidate" else "candidate"
    kinds = ["inside", "miss"] if stuck == "candidate" else ["miss", "inside"]
    tests = Passes(dut, rng, kinds[:1] * 2 + kinds[1:] * 40)
    got = await Sink(dut, free).receive(40, patience=100)

    assert got == tests.sent[kinds[1]]
    await ReadOnly()
    assert getattr(dut, f"{stuck}_valid_o").value == 1


@cocotb.test()
@cocotb.parametrize(kind=KINDS)
async def a_result_takes_two_cycles_and_one_goes_each_cycle(dut, kind):
    rng = await start(dut)
    dut.candidate_ready_i.value = dut.return_ready_i.value = 1
    tests = Passes(dut, rng, [kind] * 100)
    valid = dut.candidate_valid_o if kind == "inside" else dut.return_valid_o
    sent, came = [], []
    for at in range(200):
        await ReadOnly()
        if getattr(dut, f"{kind}_i").value == 1:
            sent.append(at)
        if valid.value == 1:
            came.append(at)
        await RisingEdge(dut.clk_i)

    assert tests.given == [kind] * 100
    assert came == [at + 2 for at in sent]
    assert sent == list(range(sent[0], sent[0] + 100))


@pytest.mark.parametrize("slots,queued", [(4, 0), (16, 0), (8, 1)])
def test_ti_ist1_egress(slots, queued):
    run("ti_ist1_egress", "test_ti_ist1_egress", NumSlots=slots, Queued=queued)
