# SPDX-License-Identifier: Apache-2.0
"""`ti_credits` has as many credits as it says, knows when one is left and when all are back."""

import cocotb
import pytest
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge


class Credits:
    """Drives the unit, one call a cycle, and counts what is out."""

    def __init__(self, dut):
        self._dut = dut
        self.num = int(dut.Num.value)
        self.out = 0

    async def cycle(self, take=False, give=False):
        """Take one and give one back, where that may be; both outputs are checked."""
        dut = self._dut
        await ReadOnly()
        assert bool(dut.any_o.value) == (self.out < self.num), f"{self.out} of {self.num} out"
        assert bool(dut.all_o.value) == (self.out == 0), f"{self.out} of {self.num} out"
        await RisingEdge(dut.clk_i)
        take, give = take and self.out < self.num, give and self.out > 0
        dut.take_i.value, dut.give_i.value = int(take), int(give)
        await RisingEdge(dut.clk_i)
        dut.take_i.value = dut.give_i.value = 0
        self.out += take - give


@cocotb.test()
async def all_can_be_taken_and_come_back(dut):
    await start(dut)
    credits_ = Credits(dut)
    for _ in range(2):
        for _ in range(credits_.num + 1):
            await credits_.cycle(take=True)
        assert credits_.out == credits_.num
        for _ in range(credits_.num + 1):
            await credits_.cycle(give=True)
        assert credits_.out == 0


@cocotb.test()
@cocotb.parametrize(p_take=[0.2, 0.5, 0.8])
async def counts_under_any_mixture(dut, p_take):
    rng = await start(dut)
    credits_ = Credits(dut)
    for _ in range(300):
        await credits_.cycle(take=rng.random() < p_take, give=rng.random() < 0.5)


@cocotb.test()
async def all_are_back_after_reset(dut):
    await start(dut)
    credits_ = Credits(dut)
    await credits_.cycle(take=True)
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1
    credits_.out = 0
    await credits_.cycle()


@pytest.mark.parametrize("num", [1, 2, 7, 16])
def test_ti_credits(num):
    run("ti_credits", "test_ti_credits", Num=num)
