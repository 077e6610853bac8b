# SPDX-License-Identifier: Apache-2.0
"""`ti_slot_pool` hands every slot out, none of them twice at a time, and takes all back."""

import cocotb
from agents.bench import run, start
from cocotb.triggers import ReadOnly, RisingEdge

# The pools of the top, how many slots they have, and after how many cycles more one comes back.
SLOTS = {0: 2, 1: 5, 2: 16, 3: 6}
LATE = {3: 1}


class Pool:
    """Drives one pool, one call a cycle, and knows which slots are out."""

    def __init__(self, dut, index):
        self._clk = dut.clk_i
        self._valid, self._slot = dut.free_valid_o[index], dut.free_slot_o[index]
        self._take, self._give = dut.take_i[index], dut.give_i[index]
        self._give_slot = dut.give_slot_i[index]
        self._slots, self._late = SLOTS[index], LATE.get(index, 0)
        self.out = []

    async def cycle(self, take=False, give=None):
        """Take a slot if there is one, bring `give` back; returns the slot that was taken."""
        await ReadOnly()
        free = self._valid.value == 1
        slot = int(self._slot.value)
        assert free == (len(self.out) < self._slots), f"free is {free} with {self.out} out"
        if free:
            assert slot < self._slots and slot not in self.out, f"{slot} with {self.out} out"
        await RisingEdge(self._clk)
        self._take.value = take and free
        self._give.value = give is not None
        self._give_slot.value = give or 0
        await RisingEdge(self._clk)
        self._take.value = self._give.value = 0
        if give is not None:
            self.out.remove(give)
            for _ in range(self._late):
                await RisingEdge(self._clk)
        if take and free:
            self.out.append(slot)
            return slot
        return None


@cocotb.test()
@cocotb.parametrize(index=list(SLOTS))
async def hands_out_ascending_slots_after_reset(dut, index):
    await start(dut)
    pool = Pool(dut, index)

    assert [await pool.cycle(take=True) for _ in range(SLOTS[index])] == list(range(SLOTS[index]))
    assert await pool.cycle(take=True) is None


@cocotb.test()
@cocotb.parametrize(index=list(SLOTS), p_take=[0.2, 0.5, 0.8])
async def never_hands_a_slot_out_twice(dut, index, p_take):
    rng = await start(dut)
    pool = Pool(dut, index)
    for _ in range(600):
        give = rng.choice(pool.out) if pool.out and rng.random() > p_take else None
        await pool.cycle(take=rng.random() < p_take, give=give)

    while pool.out:  # all come back, and all are there again
        await pool.cycle(give=rng.choice(pool.out))
    again = [await pool.cycle(take=True) for _ in range(SLOTS[index])]
    assert sorted(again) == list(range(SLOTS[index]))


@cocotb.test()
@cocotb.parametrize(index=list(SLOTS))
async def hands_the_last_slot_out_again_and_again(dut, index):
    await start(dut)
    pool = Pool(dut, index)
    for _ in range(SLOTS[index]):
        await pool.cycle(take=True)

    for slot in list(range(SLOTS[index])) * 3:
        await pool.cycle(give=slot)
        assert await pool.cycle(take=True) == slot


@cocotb.test()
@cocotb.parametrize(index=list(SLOTS))
async def takes_one_and_gives_one_in_every_cycle(dut, index):
    rng = await start(dut)
    pool = Pool(dut, index)
    for _ in range(SLOTS[index] - 1 - LATE.get(index, 0)):
        await pool.cycle(take=True)
    out = set(pool.out)
    take, give, give_slot = dut.take_i[index], dut.give_i[index], dut.give_slot_i[index]
    for _ in range(200):
        back = rng.choice(sorted(out))
        take.value, give.value, give_slot.value = 1, 1, back
        await ReadOnly()
        slot = int(dut.free_slot_o[index].value)
        assert dut.free_valid_o[index].value == 1 and slot not in out
        await RisingEdge(dut.clk_i)
        out = (out - {back}) | {slot}


def test_ti_slot_pool():
    run("ti_common_top", "test_ti_slot_pool")
