# SPDX-License-Identifier: Apache-2.0
"""`ti_core` gives each ray back once with the model's hit, whatever memory and stalls do."""

import json
import struct
from pathlib import Path

import cocotb
import ti_model
from agents.axi_memory import DECERR, EXOKAY, OKAY, SLVERR, AxiMemory
from agents.bench import run, start
from agents.stream import Sink, Source, stalls
from cocotb.triggers import ClockCycles
from models.numbers import numbers
from models.payload import configuration, payloads
from models.rays import bad_rays, parallel_rays, ray
from models.scene import BASE, Scene, rays_through, soup

STATUS_OK, INVALID_RAY, MEMORY_ERROR, WATCHDOG = range(4)
NO_PRIM = (1 << 32) - 1
UNITS = ("trv", "list", "ist1", "ist2")
WATCHDOG_STEPS = 40  # few, so that some rays reach it
HARD_CASES = Path(__file__).resolve().parents[2] / "scenes/hardcases.jsonl"


class Bench:
    """A reset engine, its memory, and one scene at a time."""

    def __init__(self, dut, rng, **memory):
        self.dut, self.rng = dut, rng
        self.memory = AxiMemory(dut, rng, **memory)
        self._next_base = BASE
        self._ids = set()

    def put_scene(self, triangles, spoil=lambda scene: scene.bytes):
        """Give the engine a scene at a place in memory that none had before."""
        scene, base = Scene(triangles), self._next_base
        self._next_base += len(scene.bytes) + 4096
        self.memory.put(base, spoil(scene))
        sections = {
            name: getattr(scene, name) - BASE + base
            for name in ("node_base", "list_base", "plane_base", "bary_base")
        }
        lo, hi = scene.box
        beat = payloads().pack("scene_t", sections, root=scene.root, box_lo=lo, box_hi=hi)
        self.dut.scene_i.value = beat
        keys = configuration()
        self.tracer = ti_model.Tracer.create(
            scene.image, keys["stack_depth"], keys["watchdog_steps"]
        )
        return scene

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
        sink, source = Sink(self.dut, "hit"), Source(self.dut, "ray")
        beats = [payloads().pack("ray_t", given) for given in rays]
        cocotb.start_soon(source.send(beats, stalls(self.rng, 1 - p_valid)))
        return await self.collect(sink, rays, ready)

    async def collect(self, sink, rays, ready=lambda: 1):
        beats = await sink.receive(len(rays), ready)
        await sink.expect_none(300)
        hits = [payloads().unpack("hit_t", bits) for bits in beats]
        assert {hit["ray_id"] for hit in hits} == {given["ray_id"] for given in rays}
        assert self.memory.in_flight() == 0
        return {hit["ray_id"]: hit for hit in hits}

    def check(self, rays, hits):
        """Every hit is the model's; returns the statuses that came."""
        for given in rays:
            want, _ = self.expected(given)
            assert hits[given["ray_id"]] == want, f"{given}\nmodel {want}"
        return {hit["status"] for hit in hits.values()}

    def counter_ports(self):
        return [getattr(self.dut, f"{unit}_counters_o") for unit in UNITS]

    def counters(self):
        """The counters of the units, of which there is one of a kind."""
        counters = {}
        for unit, port in zip(UNITS, self.counter_ports(), strict=True):
            counters |= payloads().unpack(f"{unit}_counters_t", int(port.value))
        return counters

    def check_counters(self, rays):
        done = [self.expected(given)[1] for given in rays]
        sums = {k: sum(getattr(one, k) for one in done) for k in ("steps", "leaves", "full_leaves")}
        tests = {"a_passes": "a_tests", "b_passes": "b_tests", "c_passes": "c_tests"}
        sums |= {k: sum(getattr(one, name) for one in done) for k, name in tests.items()}
        sums |= {"ids": sums["a_passes"], "restarts": sum(one.restarts for one in done)}
        got = self.counters()
        assert {k: got[k] for k in sums} == sums


@cocotb.test()
@cocotb.parametrize(
    (("p_valid", "p_ready", "latency"), [(1.0, 1.0, 1), (1.0, 1.0, 100), (0.2, 0.3, 30)])
)
async def every_ray_comes_back_once_with_the_hit_of_the_model(dut, p_valid, p_ready, latency):
    rng = await start(dut)
    bench = Bench(
        dut,
        rng,
        latency=lambda: rng.randint(1, latency),
        ready=lambda: rng.random() < p_ready,
        resp=lambda: rng.choice((OKAY, EXOKAY)),
    )
    bench.put_scene(soup(rng, 120))
    odd = [bench.ray(given, rng.getrandbits(1)) for given in (*bad_rays(), *parallel_rays())]
    rays = [*bench.rays(200), *rng.sample(odd, 50)]
    rng.shuffle(rays)

    hits = await bench.trace(rays, p_valid, lambda: rng.random() < p_ready)

    assert bench.check(rays, hits) == {STATUS_OK, INVALID_RAY, WATCHDOG}
    bench.check_counters(rays)


@cocotb.test()
async def a_hit_port_that_waits_for_long_loses_nothing(dut):
    rng = await start(dut)
    bench = Bench(dut, rng)
    bench.put_scene(soup(rng, 60))
    rays = list(bench.rays(200))
    source, sink = Source(dut, "ray"), Sink(dut, "hit")
    task = cocotb.start_soon(source.send([payloads().pack("ray_t", given) for given in rays]))
    await ClockCycles(dut.clk_i, 5000)
    asked = len(bench.memory.addresses)
    await ClockCycles(dut.clk_i, 2000)
    assert not task.done(), "it cannot hold all these rays"
    assert len(bench.memory.addresses) == asked, "everything inside waits for the hit port"

    bench.check(rays, await bench.collect(sink, rays))
    bench.check_counters(rays)


@cocotb.test()
async def a_memory_that_takes_no_request_for_long_only_delays(dut):
    rng = await start(dut)
    awake = [False]
    bench = Bench(dut, rng, ready=lambda: awake[0])
    bench.put_scene(soup(rng, 60))
    rays = list(bench.rays(100))

    async def wake():
        await ClockCycles(dut.clk_i, 3000)
        assert not bench.memory.addresses
        awake[0] = True

    cocotb.start_soon(wake())
    bench.check(rays, await bench.trace(rays))


@cocotb.test()
@cocotb.parametrize(share=[0.02, 0.3, 1.0])
async def an_error_response_ends_the_rays_that_need_the_line_and_no_other(dut, share):
    rng = await start(dut)
    share_now = [share]
    bench = Bench(
        dut,
        rng,
        latency=lambda: rng.randint(1, 40),
        resp=lambda: rng.choice((SLVERR, DECERR)) if rng.random() < share_now[0] else OKAY,
    )
    bench.put_scene(soup(rng, 120))
    rays = list(bench.rays(300))

    hits = await bench.trace(rays, 0.8, lambda: rng.random() < 0.6)

    spoilt = 0
    for given in rays:
        hit = hits[given["ray_id"]]
        if hit["status"] == MEMORY_ERROR:
            spoilt += 1
            nothing = {"hit": 0, "prim": NO_PRIM, "t": numbers().inf, "u": 0, "v": 0}
            assert {k: hit[k] for k in nothing} == nothing
        else:
            assert hit == bench.expected(given)[0]
    assert spoilt > 0
    if share == 1.0:
        assert all(
            (hits[r["ray_id"]]["status"] == MEMORY_ERROR) == (bench.expected(r)[1].steps > 0)
            for r in rays
        )

    share_now[0] = 0.0  # nothing of a bad answer may stay
    again = [bench.ray({k: given[k] for k in ("o", "d", "tmin", "tmax")}) for given in rays[:100]]
    bench.check(again, await bench.trace(again))


@cocotb.test()
async def a_tree_that_leads_in_a_circle_ends_by_the_watchdog(dut):
    """Each inner node has itself as its other child, at a plane that every ray finds beyond."""
    rng = await start(dut)
    bench = Bench(dut, rng)

    def circle(scene):
        data = bytearray(scene.bytes)
        for i, (value, link) in enumerate(scene.nodes):
            if link & 3 != 3:
                node = struct.pack("<II", value, i << 3 | link & 7)
                place = scene.image.node_offset + 8 * i
                data[place : place + 8] = node
        return bytes(data)

    bench.put_scene(soup(rng, 60), circle)
    rays = list(bench.rays(60))
    hits = await bench.trace(rays)

    ended = [hit for hit in hits.values() if hit["status"] == WATCHDOG]
    assert len(ended) > 10
    assert all((h["steps"], h["hit"], h["prim"]) == (WATCHDOG_STEPS, 0, NO_PRIM) for h in ended)


@cocotb.test()
@cocotb.parametrize(after=[1, 7, 50, 333, 1000])
async def a_reset_in_the_middle_of_traffic_forgets_all_of_it(dut, after):
    rng = await start(dut)
    bench = Bench(dut, rng, latency=lambda: rng.randint(1, 60))
    bench.put_scene(soup(rng, 120))
    source, sink = Source(dut, "ray"), Sink(dut, "hit")
    beats = [payloads().pack("ray_t", given) for given in bench.rays(400)]
    tasks = [cocotb.start_soon(source.send(beats)), cocotb.start_soon(sink.receive(len(beats)))]
    await ClockCycles(dut.clk_i, after)
    for task in tasks:
        task.cancel()

    dut.rst_ni.value, dut.ray_valid_i.value, dut.hit_ready_i.value = 0, 0, 0
    await ClockCycles(dut.clk_i, 2)
    bench.memory.forget()
    assert dut.hit_valid_o.value == 0 and dut.m_axi_arvalid.value == 0
    dut.rst_ni.value = 1
    await ClockCycles(dut.clk_i, 1)
    await Sink(dut, "hit").expect_none(200)
    assert not any(int(counters.value) for counters in bench.counter_ports())

    bench.put_scene(soup(rng, 120))
    rays = list(bench.rays(150))
    bench.check(rays, await bench.trace(rays))
    bench.check_counters(rays)


@cocotb.test()
async def hard_cases_have_the_bits_of_the_model(dut):
    """Each in a scene of its own, one after the other without a reset."""
    rng = await start(dut)
    bench = Bench(dut, rng)
    n = numbers()

    def values(words):
        return [struct.unpack(">f", bytes.fromhex(word))[0] for word in words]

    for line in HARD_CASES.read_text().splitlines():
        case = json.loads(line)
        bench.put_scene([[tuple(values(corner)) for corner in tri] for tri in case["tris"]])
        o, d = n.vec(values(case["o"])), n.vec(values(case["d"]))
        tmin, tmax = n.vec(values((case["tmin"], case["tmax"])))
        rays = [bench.ray(ray(o, d, tmin, tmax), any_hit) for any_hit in (0, 1, 0)]

        try:
            bench.check(rays, await bench.trace(rays))
        except AssertionError as error:
            raise AssertionError(f"case {case['n']}, {case['name']}: {error}") from None


def test_ti_core():
    run("ti_core", "test_ti_core", config=f"tiny watchdog_steps={WATCHDOG_STEPS}")
