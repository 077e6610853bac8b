# SPDX-License-Identifier: Apache-2.0
"""`ti_rd_shear` gives the model's axis, shear and inverse of each ray, one a cycle."""

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from models.numbers import hexed, numbers
from models.payload import payloads

FORMATS = ["", "exp_bits=5 frac_bits=10"]


def directions(rng, count):
    """Ties of all kinds with both signs, then special and ordinary directions, none infinite."""
    n = numbers()
    for d in [(a, b, c) for a in (0, n.one) for b in (0, n.one) for c in (0, n.one)]:
        yield d
        yield tuple(x | n.sign for x in d)
    for _ in range(count):
        d = n.any_vec(rng)
        finite = all(x & (n.sign - 1) < n.inf for x in d)
        yield d if finite and rng.random() < 0.5 else n.direction(rng)


@cocotb.test()
async def gives_what_the_model_gives(dut):
    rng = await start(dut)
    n, p = numbers(), payloads()
    todo = [(d, tuple(n.model("fp_rcp", x) for x in d)) for d in directions(rng, 2000)]
    beats = [{"d_i": p.pack_vec(d), "inv_i": p.pack_vec(inv)} for d, inv in todo]

    sent, got = await replay(
        dut, beats, read=lambda: (int(dut.z_o.value), p.unpack_vec(int(dut.shear_o.value)))
    )

    assert sent == list(range(len(todo)))
    assert [cycle for cycle, _ in got] == [cycle + int(dut.Latency.value) for cycle in sent]
    for (d, inv), (_, result) in zip(todo, got, strict=True):
        z, shear = n.model("shear", d, inv)
        want = z, tuple(shear)
        assert result == want, f"{hexed(d)}: want {hexed(want)}, got {hexed(result)}"
        assert all(x & (n.sign - 1) <= d[z] & (n.sign - 1) for x in d)


@pytest.mark.parametrize("overrides", FORMATS)
def test_ti_rd_shear(overrides):
    run("ti_rd_shear", "test_ti_rd_shear", config=f"tiny {overrides}")
