# SPDX-License-Identifier: Apache-2.0
"""`ti_woop_level` brings weights to the size that the model brings them to."""

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from models.numbers import hexed, numbers
from models.payload import payloads

FORMATS = ["", "exp_bits=5 frac_bits=10", "exp_bits=5 frac_bits=10 rounding=zero subnormals=flush"]


def weights(rng, count):
    """Zeros, subnormals and every other size, alike and far apart; no NaN."""
    n = numbers()
    yield (0, 0, 0)
    yield (n.sign, 0, n.sign)
    while count > 0:
        weight = n.any_vec(rng)
        if rng.random() < 0.5:
            size = 2.0 ** -rng.randrange(-n.bias + 2, n.bias + n.frac_bits)
            weight = n.vec(size * rng.choice((0, 1, rng.uniform(0, 1))) for _ in range(3))
        if all(x & (n.sign - 1) <= n.inf for x in weight):
            count -= 1
            yield weight


@cocotb.test()
async def gives_what_the_model_gives(dut):
    rng = await start(dut)
    n, p = numbers(), payloads()
    todo = list(weights(rng, 2000))
    beats = [{"weight_i": p.pack_vec(weight)} for weight in todo]

    sent, got = await replay(dut, beats, read=lambda: p.unpack_vec(int(dut.level_o.value)))

    assert [cycle for cycle, _ in got] == [cycle + int(dut.Latency.value) for cycle in sent]
    for weight, (_, level) in zip(todo, got, strict=True):
        want = n.model("woop_level", weight)
        assert level == want, f"{hexed(weight)}: want {hexed(want)}, got {hexed(level)}"
        sizes = [x & (n.sign - 1) for x in weight]
        if 0 < max(sizes) < n.inf:
            assert 2 <= max(abs(n.float(x)) for x in level) < 4


@pytest.mark.parametrize("overrides", FORMATS)
def test_ti_woop_level(overrides):
    run("ti_woop_level", "test_ti_woop_level", config=f"tiny triangle_test=woop {overrides}")
