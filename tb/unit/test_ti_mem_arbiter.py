# SPDX-License-Identifier: Apache-2.0
"""`ti_mem_arbiter` passes every line request on once and brings each answer to who asked."""

import cocotb
import pytest
from agents.bench import cycle, run, start
from agents.memory import LineMemory
from cocotb.triggers import ReadOnly, RisingEdge

MEMORY_PORTS = {
    "ask_valid": "mem_valid_o",
    "ask_ready": "mem_ready_i",
    "ask_id": "mem_id_o",
    "ask_line": "mem_line_o",
    "answer_valid": "rsp_valid_i",
    "answer_id": "rsp_id_i",
}


class Ports:
    """All requesters.  Each has `2^RowWidth` rows and at most one request in flight a row."""

    def __init__(self, dut, memory, rng):
        self._dut, self._memory, self._rng = dut, memory, rng
        self.num = int(dut.NumPorts.value)
        self._row_width = int(dut.RowWidth.value)
        self._line_width = int(dut.LineAddrWidth.value)
        self._free = [set(range(1 << self._row_width)) for _ in range(self.num)]
        self._offer = [None] * self.num  # (row, line)
        self._asking = {}  # line -> (port, row), from taken to answered
        self.order = []  # lines, as the ports handed them over
        self.left = [0] * self.num
        self.gap = lambda: False
        self.taken = []  # ports, in the order served
        self.first_taken = None  # cycle
        self.answered = 0

    async def play(self):
        """Until every request has been answered."""
        while any(self.left) or any(self._offer) or self._asking:
            self._drive()
            await ReadOnly()
            self._see_answer()
            self._see_requests()
            await RisingEdge(self._dut.clk_i)

    def _drive(self):
        valid = rows = lines = 0
        for port in range(self.num):
            if self._offer[port] is None and self.left[port] and self._free[port]:
                if self.gap():
                    continue
                self.left[port] -= 1
                row = self._rng.choice(sorted(self._free[port]))
                line = self._rng.getrandbits(self._line_width)
                while line in self._asking:
                    line = self._rng.getrandbits(self._line_width)
                self._offer[port] = (row, line)
            if self._offer[port] is not None:
                row, line = self._offer[port]
                valid |= 1 << port
                rows |= row << port * self._row_width
                lines |= line << port * self._line_width
        self._dut.req_valid_i.value = valid
        self._dut.req_row_i.value = rows
        self._dut.req_line_i.value = lines

    def _see_requests(self):
        ready = int(self._dut.req_ready_o.value)
        for port in range(self.num):
            if self._offer[port] is not None and ready >> port & 1:
                row, line = self._offer[port]
                self._offer[port] = None
                self._free[port].remove(row)
                self._asking[line] = (port, row)
                self.order.append(line)
                self.taken.append(port)
                self.first_taken = self.first_taken or cycle()

    def _see_answer(self):
        valid = int(self._dut.rsp_valid_o.value)
        if not self._memory.answered or self._memory.answered[-1][0] != cycle():
            assert valid == 0, "an answer that the memory has not given"
            return
        _, line, _ = self._memory.answered[-1]
        assert line in self._asking, f"line {line:#x} was answered, nobody asked for it"
        port, row = self._asking.pop(line)
        assert valid == 1 << port, f"line {line:#x} of port {port} went to {valid:#b}"
        assert int(self._dut.rsp_row_o.value) == row
        self._free[port].add(row)
        self.answered += 1


async def begin(dut):
    rng = await start(dut)
    memory = LineMemory(dut, 8, rng, MEMORY_PORTS)
    cocotb.start_soon(memory.run())
    return rng, memory, Ports(dut, memory, rng)


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.6], p_ready=[0.3, 1.0], most=[1, 30])
async def answers_every_request_at_the_right_port_and_row(dut, p_gap, p_ready, most):
    rng, memory, ports = await begin(dut)
    memory.ready = lambda: rng.random() < p_ready
    memory.latency = lambda line: rng.randint(1, most)
    ports.gap = lambda: rng.random() < p_gap
    ports.left = [200] * ports.num

    await ports.play()

    assert ports.answered == 200 * ports.num
    assert memory.asked == ports.order, "requests changed or overtook each other"


@cocotb.test()
async def passes_one_request_a_cycle_and_serves_the_ports_in_turn(dut):
    _, memory, ports = await begin(dut)
    memory.latency = lambda line: 1
    ports.left = [100] * ports.num

    await ports.play()

    if ports.num << int(dut.RowWidth.value) >= 4:  # else the requesters wait for their answers
        assert memory.answered[-1][0] - memory.answered[0][0] == 100 * ports.num - 1
        assert memory.answered[0][0] - ports.first_taken == 2
    turns = ports.taken
    for at in range(len(turns) - 2 * ports.num):
        assert sorted(turns[at : at + ports.num]) == list(range(ports.num)), f"from {at}"


@cocotb.test()
async def a_stalled_request_stays_as_it_is(dut):
    _, memory, ports = await begin(dut)
    memory.ready = lambda: False
    ports.left = [1] * ports.num
    cocotb.start_soon(ports.play())
    for _ in range(3):
        await RisingEdge(dut.clk_i)
    await ReadOnly()
    first = (int(dut.mem_id_o.value), int(dut.mem_line_o.value))
    for _ in range(10):
        await RisingEdge(dut.clk_i)
        await ReadOnly()
        assert dut.mem_valid_o.value == 1
        assert (int(dut.mem_id_o.value), int(dut.mem_line_o.value)) == first


@pytest.mark.parametrize(("ports", "row_width"), [(1, 2), (3, 1), (4, 3)])
def test_ti_mem_arbiter(ports, row_width):
    run("ti_mem_arbiter", "test_ti_mem_arbiter", NumPorts=ports, RowWidth=row_width)
