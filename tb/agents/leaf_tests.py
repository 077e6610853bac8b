# SPDX-License-Identifier: Apache-2.0
"""Stand in for LIST, IST1 and IST2 behind one TRV: answer the tests of its leaves."""

import cocotb
from agents.stream import Sink, Source
from cocotb.triggers import RisingEdge
from models.payload import payloads


class LeafTests:
    """Takes `leaf`, gives `return`: a token a test with the model's result, in random order.

    With `misses` all tests of a leaf miss, in one token.  `ready()` is the ready bit of each cycle,
    `gap()` the number of idle cycles before a token.  `leaves` lists the leaves as they came.
    """

    def __init__(self, dut, scene, rng, *, misses=False, ready=lambda: 1, gap=lambda: 0):
        self._scene, self._rng, self._misses = scene, rng, misses
        self._ready, self._gap, self._clk = ready, gap, dut.clk_i
        self._tokens = []
        self.leaves = []
        cocotb.start_soon(self._take(Sink(dut, "leaf")))
        cocotb.start_soon(self._give(Source(dut, "return")))

    async def _take(self, sink):
        while True:
            [bits] = await sink.receive(1, self._ready)
            leaf = payloads().unpack("leaf_t", bits)
            self.leaves.append(leaf)
            self._tokens += [payloads().pack("return_t", token) for token in self._answers(leaf)]

    def _answers(self, leaf):
        if self._misses:
            yield {"home": leaf["home"], "count": leaf["count"]}
            return
        for record in self._scene.ids[leaf["first"] : leaf["first"] + leaf["count"]]:
            token = {"home": leaf["home"], "count": 1}
            hit = self._scene.test(record, leaf["operands"], leaf["tnear"], leaf["tfar"]).hit
            if hit:
                token.update(zip("tuv", hit, strict=True), hit=1, prim=self._scene.prim(record))
            yield token

    async def _give(self, source):
        while True:
            if self._tokens:
                which = self._rng.randrange(len(self._tokens))
                await source.send([self._tokens.pop(which)], self._gap)
            else:
                await RisingEdge(self._clk)
