# SPDX-License-Identifier: Apache-2.0
"""A `ti_ra` with a memory behind it and slots in front of it, and what its tests ask for."""

import cocotb
from agents.bench import start
from agents.memory import LineMemory
from agents.requesters import Requesters, Retriers
from models.payload import configuration, parameter, payloads

GATHER, RETRY, BLOCKING = range(3)  # of ti_config_pkg::ray_accumulation_e
MODE = parameter("Mode", GATHER)
SLOTS, ROWS, WAYS = (parameter(name, 1) for name in ("NumSlots", "Rows", "Ways"))
STAGES = parameter("LookupStages", 1)
# Cycles in which a line is stored.
WORDS = parameter("LineBytes", 1) // parameter("WordBytes", 1)
QUEUED = {3: 2, 4: 3, 5: 3}.get(STAGES, 0)  # answers between the line store and the port
ROW_IDS = 1 << payloads().width("row_id_t") if hasattr(cocotb, "top") else 1
PLACES = parameter("CacheBytes", 1) // parameter("LineBytes", 1)
PATTERNS = ["one line", "walk", "every line", "one set", "near", "far"]


async def begin(dut):
    """Start the unit with a memory behind it and slots in front of it."""
    rng = await start(dut)
    memory, slots, _ = play(dut, rng)
    return rng, memory, slots


def play(dut, rng):
    """Memory and slots of a unit that has been reset, and the tasks that play them."""
    memory = LineMemory(dut, configuration()["line_bytes"], rng)
    slots = (Retriers if MODE == RETRY else Requesters)(dut, memory, rng)
    return memory, slots, [cocotb.start_soon(memory.run()), cocotb.start_soon(slots.run())]


def pattern(name, slots, rng, count):
    """Addresses of an access pattern."""
    kept = slots.sets * slots.ways
    top = (1 << configuration()["addr_bits"]) // slots.line_bytes - 1
    lines = {
        "one line": lambda i: 5,
        "walk": lambda i: i * slots.elem_bytes // slots.line_bytes,
        "every line": lambda i: i,
        "one set": lambda i: slots.line_of(slots.sets - 1, rng.randrange(slots.ways + 2)),
        "near": lambda i: rng.randrange(2 * kept),
        "far": lambda i: rng.choice([0, 1, top - 1, top, rng.randrange(top)]),
    }[name]
    return [slots.any_addr(lines(i)) for i in range(count)]
