# SPDX-License-Identifier: Apache-2.0
"""An engine with its memory: scenes, rays through its streams, what it counted."""

from itertools import product

import cocotb
import counters
from agents.axi_memory import AxiMemory
from agents.lanes import Lanes
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles
from models.numbers import numbers
from models.payload import configuration, payloads
from models.rays import ray
from models.scene import BASE, Scene, rays_through
from models.traced import NO_PRIM, tracer

PATIENCE = 20_000  # cycles without a hit after which a ray is lost


class Bench:
    """A reset engine, its memory, and one scene at a time."""

    def __init__(self, dut, rng, **memory):
        self.dut, self.rng = dut, rng
        lanes = Lanes(dut)
        self.streams = [lanes[stream] for stream in range(configuration()["streams"])]
        self.dut.count_run_i.value = 1
        keys = configuration()
        memory = {"stalls": keys["fill_bytes"] < keys["line_bytes"], **memory}
        self.memories = [AxiMemory(dut, rng, c, **memory) for c in range(keys["cores"])]
        self._next_base = BASE
        self._ids = set()

    def after_reset(self):
        """The same bench with streams that have put nothing on their ports yet."""
        lanes = Lanes(self.dut)
        self.streams = [lanes[stream] for stream in range(len(self.streams))]
        return self

    def put_scene(self, triangles, spoil=lambda scene: scene.bytes):
        """Give the engine a scene at a place in memory that none had before."""
        scene, base = Scene(triangles), self._next_base
        self._next_base += len(scene.bytes) + 4096
        for memory in self.memories:
            memory.put(base, spoil(scene))
        sections = {
            name: getattr(scene, name) - BASE + base
            for name in ("node_base", "list_base", "plane_base", "bary_base")
        }
        lo, hi = scene.box
        counts = {"num_list": len(scene.ids), "num_records": scene.count}
        beat = payloads().pack("scene_t", sections | counts, root=scene.root, box_lo=lo, box_hi=hi)
        self.dut.scene_i.value = beat
        keys = configuration()
        self.tracer = tracer(scene, keys["stack_depth"], keys["watchdog_steps"])
        return scene

    def forget_scenes(self):
        """The next scene comes to where the last one was."""
        self._next_base = BASE
        for memory in self.memories:
            memory.clear()

    def ray(self, given, any_hit=0):
        """A ray under a number that none had before."""
        ray_id = next(n for n in iter(lambda: self.rng.getrandbits(32), None) if n not in self._ids)
        self._ids.add(ray_id)
        return {"ray_id": ray_id, "any_hit": any_hit, **given}

    def rays(self, count):
        """Closest-hit and any-hit rays through the scene, some with an interval."""
        n, rng = numbers(), self.rng
        for o, d in rays_through(rng, count):
            tmin = n.of(rng.choice((0.0, 0.0, 0.5)))
            tmax = rng.choice((n.inf, n.inf, n.of(rng.uniform(1, 3))))
            yield self.ray(ray(o, d, tmin, tmax), any_hit=rng.getrandbits(1))

    def expected(self, given):
        """(the hit of the model, what the ray did)."""
        n = numbers()
        o, d = ([n.float(x) for x in given[k]] for k in "od")
        tmin, tmax = n.float(given["tmin"]), n.float(given["tmax"])
        traced = self.tracer.trace(o, d, tmin, tmax, bool(given["any_hit"]))
        found = traced.prim >= 0
        hit = {k: getattr(traced, k) for k in ("t", "u", "v", "status")}
        hit |= {"ray_id": given["ray_id"], "hit": int(found), "steps": traced.hit_steps}
        return hit | {"prim": traced.prim if found else NO_PRIM}, traced

    async def trace(self, rays, p_valid=1.0, ready=lambda: 1):
        """Send the rays, take as many hits; by ray id."""
        self.send(rays, p_valid)
        return await self.collect(rays, ready)

    def send(self, rays, p_valid=1.0):
        """Ray i goes to stream i modulo their number; a task a stream."""
        gap = stalls(self.rng, 1 - p_valid)
        return [
            cocotb.start_soon(Source(stream, "ray").send(beats, gap))
            for stream, beats in self._dealt(rays)
        ]

    async def collect(self, rays, ready=lambda: 1):
        """Each hit comes at the stream of its ray."""
        tasks = [
            (cocotb.start_soon(Sink(stream, "hit").receive(len(beats), ready, PATIENCE)), beats)
            for stream, beats in self._dealt(rays)
        ]
        hits = {}
        for task, beats in tasks:
            mine = [payloads().unpack("hit_t", bits) for bits in await task]
            sent = {payloads().unpack("ray_t", bits)["ray_id"] for bits in beats}
            assert {hit["ray_id"] for hit in mine} == sent
            hits |= {hit["ray_id"]: hit for hit in mine}
        await self.expect_no_hit(300)
        assert self.in_flight() == 0 and self.dut.idle_o.value == 1
        return hits

    async def expect_no_hit(self, cycles):
        for task in [
            cocotb.start_soon(Sink(stream, "hit").expect_none(cycles)) for stream in self.streams
        ]:
            await task

    def _dealt(self, rays):
        """(stream, beats of its rays), streams without a ray left out."""
        beats = [payloads().pack("ray_t", given) for given in rays]
        number = len(self.streams)
        return [(s, beats[i::number]) for i, s in enumerate(self.streams) if beats[i::number]]

    def check(self, rays, hits):
        """Every hit is the model's; returns the statuses that came."""
        for given in rays:
            want, _ = self.expected(given)
            assert hits[given["ray_id"]] == want, f"{given}\nmodel {want}"
        return {hit["status"] for hit in hits.values()}

    def in_flight(self):
        return sum(memory.in_flight() for memory in self.memories)

    def asked(self):
        return sum(len(memory.addresses) for memory in self.memories)

    async def count(self, core, index, event):
        """One counter of a unit, whose number is among all units of the core."""
        dut = self.dut
        dut.count_core_i.value, dut.count_unit_i.value, dut.count_event_i.value = core, index, event
        await ClockCycles(dut.clk_i, 3)
        return int(dut.count_o.value)

    async def each(self, unit, event):
        """A counter of all units of a kind, core by core."""
        table, keys = counters.description(), configuration()
        numbers_of = counters.counts_of(keys)
        kinds = list(numbers_of)
        first = sum(numbers_of[kind] for kind in kinds[: kinds.index(unit)])
        units = product(range(keys["cores"]), range(first, first + numbers_of[unit]))
        number = list(counters.events(table, counters.kinds(table)[unit])).index(event)
        return [await self.count(core, index, number) for core, index in units]

    async def counters(self):
        """{unit: {event: sum over units and cores}}, and the cycles that each unit accounts for."""
        dut, keys = self.dut, configuration()
        dut.count_run_i.value = 0
        table, first, sums, accounts = counters.description(), 0, {}, set()
        for unit, number in counters.counts_of(keys).items():
            names = list(counters.events(table, counters.kinds(table)[unit]))
            sums[unit] = dict.fromkeys(names, 0)
            for core, index in product(range(keys["cores"]), range(first, first + number)):
                own = []
                for event, name in enumerate(names):
                    own.append(await self.count(core, index, event))
                    sums[unit][name] += own[-1]
                accounts.add(sum(own[: len(table["activity"])]))
            first += number
        dut.count_run_i.value = 1
        return sums, accounts

    async def check_counters(self, rays):
        """What was counted is what the model did; all units account for as many cycles."""
        done = [self.expected(given)[1] for given in rays]
        want = {k: sum(getattr(one, k) for one in done) for k in ("steps", "leaves", "full_leaves")}
        want["restarts"] = sum(one.restarts for one in done)
        got, accounts = await self.counters()
        trv = got["trv"]
        trv["restarts"] += trv["restarts_after_tests"]
        assert {k: trv[k] for k in want} == want
        tests = {k: sum(getattr(one, k) for one in done) for k in ("a_tests", "b_tests", "c_tests")}
        assert got["list"]["ids"] == got["ist1"]["a_passes"] == tests["a_tests"]
        assert (got["ist1"]["b_passes"], got["ist2"]["c_passes"]) == (
            tests["b_tests"],
            tests["c_tests"],
        )
        assert trv["rays"] + got["rd"]["misses"] == got["rd"]["rays"] == len(rays)
        lines = 0
        for unit in ("trv", "list", "ist1"):
            missed, l2 = got[unit]["l1_misses"], got[f"{unit}_l2"]
            if configuration()[f"{unit}_l2_bytes"]:
                assert l2["accesses"] == missed == l2["hits"] + l2["merged"] + l2["misses"]
            lines += l2["misses"] if configuration()[f"{unit}_l2_bytes"] else missed
        assert got["axi"]["lines"] == lines
        assert len(accounts) == 1 and min(accounts) > 0, "activities add up to the cycles"
