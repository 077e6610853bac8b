# SPDX-License-Identifier: Apache-2.0
"""`ti_top_wrapper` as a host sees it: registers, packets of rays and of hits, memory."""

import logging
import random
import struct
from itertools import repeat

import cocotb
import configure
import wrapper
from agents.bench import BUILD, packages
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, with_timeout
from cocotbext.axi import (
    AxiLiteBus,
    AxiLiteMaster,
    AxiRamRead,
    AxiReadBus,
    AxiResp,
    AxiStreamBus,
    AxiStreamFrame,
    AxiStreamSink,
    AxiStreamSource,
)
from models import traced
from models.payload import configuration
from models.scene import BASE, Scene
from ti_regs import REGISTERS

PERIOD_NS = 10
STREAM_PERIODS_NS = (7, 23)  # of the streams that have clocks of their own, in turn
MEMORY_BYTES = 1 << 22
HIT_WORDS = ("ray_id", "prim", "t", "u", "v", "status", "steps")
PATIENCE_US = 2000


def sources(config):
    """The wrapper of a configuration, and what `bench.run` reads in front of it."""
    name, *overrides = config.split()
    found = configure.load(name, overrides)
    folder = BUILD / "unit/wrapper" / found.machine
    folder.mkdir(parents=True, exist_ok=True)
    text = wrapper.verilog(found.name, found.machine, wrapper.buses(found.values))
    configure.write(folder, {f"{wrapper.NAME}.v": text})
    return [*packages(), folder / f"{wrapper.NAME}.v"]


class Memory(AxiRamRead):
    """Lines in `slverr` and `decerr`, ranges of addresses, are answered so."""

    def __init__(self, *arguments, **keywords):
        self.slverr = self.decerr = range(0)
        super().__init__(*arguments, size=MEMORY_BYTES, **keywords)
        self._send, self.r_channel.send = self.r_channel.send, self._answer
        self._address = 0
        self.reads = 0

    async def _read(self, address, length):
        self._address = address
        self.reads += 1
        return await super()._read(address, length)

    async def _answer(self, beat):
        if self._address in self.slverr:
            beat.rresp = AxiResp.SLVERR
        elif self._address in self.decerr:
            beat.rresp = AxiResp.DECERR
        if beat.rresp:
            beat.rdata = random.getrandbits(8 * self.byte_lanes)
        await self._send(beat)


class Top:
    """A host beside the wrapper."""

    def __init__(self, dut, rng):
        self.dut, self.rng, self.config = dut, rng, configuration()
        reset = {"reset": dut.aresetn, "reset_active_level": False}
        self.axil = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.aclk, **reset)
        self.memories = [
            Memory(AxiReadBus.from_prefix(dut, f"m{core:02}_axi"), dut.aclk, **reset)
            for core in range(self.config["cores"])
        ]
        self.sources, self.sinks = [], []
        for stream in range(self.config["streams"]):
            clock = getattr(dut, f"axis{stream:02}_aclk") if self.own else dut.aclk
            rays = AxiStreamBus.from_prefix(dut, f"s{stream:02}_axis_ray")
            hits = AxiStreamBus.from_prefix(dut, f"m{stream:02}_axis_hit")
            self.sources.append(AxiStreamSource(rays, clock, **reset))
            self.sinks.append(AxiStreamSink(hits, clock, **reset))
        self.channels = [
            *self.sources,
            *self.sinks,
            *(channel for m in self.memories for channel in (m.ar_channel, m.r_channel)),
            self.axil.write_if.aw_channel,
            self.axil.write_if.w_channel,
            self.axil.write_if.b_channel,
            self.axil.read_if.ar_channel,
            self.axil.read_if.r_channel,
        ]

    @property
    def own(self):
        return self.config["stream_clock"] == "own"

    def stall(self, share):
        """Each channel pauses in so many of its cycles."""
        for channel in self.channels:
            channel.set_pause_generator(self.rng.random() < share for _ in repeat(None))

    async def reset(self):
        """All of it, memory and streams as well."""
        self.dut.aresetn.value = 0
        await ClockCycles(self.dut.aclk, 20)
        self.dut.aresetn.value = 1
        await ClockCycles(self.dut.aclk, 10)
        for sink in self.sinks:
            sink.clear()

    # --- Registers ------------------------------------------------------------------------------

    async def write(self, name, value=None, **fields):
        """Write a word, or the fields that are named, 0 elsewhere."""
        register = REGISTERS[name]
        for key, number in fields.items():
            value = (value or 0) | number << register.fields[key].low
        answer = await self.axil.write(register.offset, struct.pack("<I", value))
        assert answer.resp == AxiResp.OKAY, name

    async def read(self, name, field=None):
        answer = await self.axil.read(REGISTERS[name].offset, 4)
        assert answer.resp == AxiResp.OKAY, name
        word = int.from_bytes(answer.data, "little")
        return word if field is None else REGISTERS[name].fields[field].of(word)

    async def wide(self, name):
        low = await self.read(f"{name}_LO")
        return low | await self.read(f"{name}_HI") << 32

    async def until(self, name, field, value):
        """Read until the field has that value."""
        for _ in range(2000):
            if await self.read(name, field) == value:
                return
        raise AssertionError(f"{name}.{field} does not become {value}")

    async def count(self, core, unit, event):
        await self.write("COUNTER_SELECT", core=core, unit=unit, event_number=event)
        return await self.wide("COUNTER")

    # --- Scenes and rays ------------------------------------------------------------------------

    async def put_scene(self, triangles, base=BASE):
        """Into memory and registers, by a host that has stopped the engine or not begun."""
        scene, config = Scene(triangles), self.config
        for memory in self.memories:
            memory.write(base, scene.bytes)
        for part in ("node", "list", "plane", "bary"):
            address = getattr(scene, f"{part}_base") - BASE + base
            await self.write(f"{part.upper()}_BASE_LO", address & 0xFFFFFFFF)
            await self.write(f"{part.upper()}_BASE_HI", address >> 32)
        await self.write("ROOT", scene.root)
        await self.write("NUM_LIST", len(scene.ids))
        await self.write("NUM_RECORDS", scene.count)
        for end, corner in zip(("LO", "HI"), scene.box, strict=True):
            for axis, value in enumerate(corner):
                await self.write(f"BOX_{end}_{axis}", value)
        self.tracer = traced.tracer(scene, config["stack_depth"], config["watchdog_steps"])
        return scene

    def rays(self, count):
        return list(traced.random_rays(self.rng, count))

    def send(self, rays, stream=0):
        """One packet."""
        words = b"".join(
            struct.pack("<8I", *ray["o"], ray["tmin"], *ray["d"], ray["tmax"]) for ray in rays
        )
        self.sources[stream].send_nowait(AxiStreamFrame(words))

    async def packet(self, stream=0):
        """The hits up to the next TLAST, in the order in which they came."""
        frame = await with_timeout(self.sinks[stream].recv(), PATIENCE_US, "us")
        assert len(frame.tdata) % 32 == 0
        hits = []
        for words in struct.iter_unpack("<8I", bytes(frame.tdata)):
            assert words[7] == 0
            hits.append(dict(zip(HIT_WORDS, words, strict=False)))
        return hits

    async def trace(self, rays, stream=0):
        self.send(rays, stream)
        return await self.packet(stream)

    def expected(self, rays, any_hit=0):
        """The hits of the model by number."""
        wanted = {}
        for number, ray in enumerate(rays):
            hit = traced.hit_of(traced.trace(self.tracer, ray, any_hit), number, any_hit)
            wanted[number] = {key: hit[key] for key in HIT_WORDS}
        return wanted

    def check(self, rays, hits, any_hit=0):
        """The packet is that of the rays: each once, with the bits of the model."""
        assert len(hits) == len(rays)
        assert {hit["ray_id"]: hit for hit in hits} == self.expected(rays, any_hit)

    async def nothing_more(self):
        """No hit comes behind the packets that were taken."""
        await ClockCycles(self.dut.aclk, 100)
        for stream, sink in enumerate(self.sinks):
            valid = getattr(self.dut, f"m{stream:02}_axis_hit_tvalid").value
            assert sink.empty() and valid == 0, stream


async def begin(dut, stall=0.0):
    """A reset top, its host; the streams run at other clocks where they have their own."""
    logging.getLogger(f"cocotb.{dut._name}").setLevel(logging.WARNING)  # not each beat of a bus
    rng = random.Random(cocotb.RANDOM_SEED)
    Clock(dut.aclk, PERIOD_NS, unit="ns").start()
    if configuration()["stream_clock"] == "own":
        for stream in range(configuration()["streams"]):
            period = 1000 * STREAM_PERIODS_NS[stream % len(STREAM_PERIODS_NS)]
            clock = getattr(dut, f"axis{stream:02}_aclk")
            Clock(clock, period, unit="ps", period_high=period // 2).start()
    dut.aresetn.value = 0
    top = Top(dut, rng)
    await top.reset()
    top.stall(stall)
    return top
