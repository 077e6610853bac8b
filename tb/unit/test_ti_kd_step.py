# SPDX-License-Identifier: Apache-2.0
"""`ti_kd_step` gives the model's t of every node and ray after `Latency`, one a cycle."""

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from cocotb.triggers import ReadOnly, RisingEdge
from models.numbers import hexed, numbers
from models.payload import parameter, payloads

FORMATS = [
    "",
    "exp_bits=7 frac_bits=16 lookup_stages=4",
    "exp_bits=5 frac_bits=10 rounding=zero subnormals=flush",
]
TAG_WIDTH = 9


def node_word(rng, axis):
    """The upper word of a node: link, reorder flag, axis."""
    return rng.getrandbits(29) << 3 | rng.getrandbits(1) << 2 | axis


def cases(rng, count):
    """Rays in the plane and on it, infinities, then mixtures of special and ordinary numbers."""
    n = numbers()
    one, two = n.one, n.of(2.0)
    in_plane = [(one, one, s | n.inf) for s in (0, n.sign)]  # 0 * inf
    in_plane += [(0, z, n.inf) for z in (0, n.sign)]
    corners = [
        *in_plane,
        (two, one, n.inf),
        (one, two, n.inf),
        (n.inf - 1, n.sign | (n.inf - 1), one),  # overflow of the difference
        (n.inf - 1, 0, two),
        (1, 0, 1),  # least subnormals
        (2, 1, n.inf - 1),
        (one + 1, one, one),  # cancellation
        (one, one, two),
    ]
    for split, o, inv in corners:
        for axis in range(3):
            yield beat(rng, axis, split, vec_with(rng, axis, o), vec_with(rng, axis, inv))
    for _ in range(count):
        axis = rng.randrange(4)
        if rng.random() < 0.5:
            yield beat(rng, axis, n.any(rng), n.any_vec(rng), n.any_vec(rng))
        else:
            o = n.vec(rng.uniform(-9, 9) for _ in range(3))
            inv = n.vec(1 / rng.uniform(0.01, 1) for _ in range(3))
            yield beat(rng, axis, n.of(rng.uniform(-9, 9)), o, inv)


def vec_with(rng, axis, value):
    vec = list(numbers().any_vec(rng))
    vec[axis] = value
    return tuple(vec)


def beat(rng, axis, split, o, inv):
    return {
        "split": split,
        "word": node_word(rng, axis),
        "o": o,
        "most": o if rng.random() < 0.5 else numbers().any_vec(rng),
        "inv": inv,
        "tag": rng.getrandbits(TAG_WIDTH),
    }


def ports(case):
    p = payloads()
    return {
        "node_i": case["word"] << 32 | case["split"],
        "origins_i": p.pack("origins_t", least=case["o"], most=case["most"]),
        "inv_i": p.pack_vec(case["inv"]),
        "tag_i": case["tag"],
    }


def expected(case):
    """(tag, node, sign of the direction, least and greatest t); none of these for a leaf."""
    n, axis = numbers(), case["word"] & 3
    node = case["word"] << 32 | case["split"]
    if axis == 3:
        return case["tag"], node, None, None, None
    origins = (case["o"], case["most"]) if parameter("Padded") else (case["o"],) * 2
    t = [n.model("split_distance", case["split"], case["word"], o, case["inv"]) for o in origins]
    return case["tag"], node, case["inv"][axis] >> (n.width - 1), *t


def reader(dut):
    def read():
        node = int(dut.node_o.value)
        rest = (None,) * 3
        if node >> 32 & 3 != 3:
            rest = tuple(int(o.value) for o in (dut.negative_o, dut.t_o, dut.t_most_o))
        return int(dut.tag_o.value), node, *rest

    return read


@cocotb.test()
async def computes_what_the_model_computes(dut):
    rng = await start(dut)
    todo = list(cases(rng, 3000))

    _, got = await replay(dut, [ports(case) for case in todo], read=reader(dut))

    assert len(got) == len(todo)
    for case, (_, result) in zip(todo, got, strict=True):
        want = expected(case)
        assert result == want, f"{hexed(case)}: want {hexed(want)}, got {hexed(result)}"


@cocotb.test()
async def gives_nan_exactly_to_rays_in_the_plane(dut):
    rng = await start(dut)
    n = numbers()
    todo = [
        beat(rng, axis, split, vec_with(rng, axis, o), vec_with(rng, axis, s | n.inf))
        for axis in range(3)
        for s in (0, n.sign)
        for split, o in [(n.one, n.one), (0, n.sign), (n.one, n.one + 1), (1, 0), (n.one, 0)]
    ]

    _, got = await replay(dut, [ports(case) for case in todo], read=reader(dut))

    for case, (_, (_, _, _, t, _)) in zip(todo, got, strict=True):
        o = case["o"][case["word"] & 3]
        in_plane = n.model("fp_eq", case["split"], o)
        assert (t == n.nan) == in_plane and t & (n.sign - 1) >= n.inf, hexed(case)


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5, 0.9])
async def keeps_its_latency_with_and_without_bubbles(dut, p_gap):
    rng = await start(dut)
    todo = list(cases(rng, 150))
    gap = (lambda: rng.random() < p_gap) if p_gap else (lambda: False)

    sent, got = await replay(dut, [ports(case) for case in todo], gap=gap, read=reader(dut))

    assert [cycle for cycle, _ in got] == [cycle + int(dut.Latency.value) for cycle in sent]
    assert [result for _, result in got] == [expected(case) for case in todo]


@cocotb.test()
async def takes_and_gives_one_a_cycle(dut):
    rng = await start(dut)
    todo = list(cases(rng, 100))

    sent, got = await replay(dut, [ports(case) for case in todo], read=reader(dut))

    assert sent == list(range(len(todo)))
    assert [cycle - got[0][0] for cycle, _ in got] == list(range(len(todo)))


@cocotb.test()
async def forgets_what_is_inside_on_reset(dut):
    await start(dut)
    dut.valid_i.value = 1
    for _ in range(int(dut.Latency.value) + 2):
        await RisingEdge(dut.clk_i)
    dut.valid_i.value = 0
    dut.rst_ni.value = 0
    await RisingEdge(dut.clk_i)
    dut.rst_ni.value = 1

    for _ in range(int(dut.Latency.value) + 2):
        await ReadOnly()
        assert dut.valid_o.value == 0
        await RisingEdge(dut.clk_i)


@pytest.mark.parametrize("overrides", FORMATS)
@pytest.mark.parametrize("padded", [0, 1])
def test_ti_kd_step(overrides, padded):
    params = {"TagWidth": TAG_WIDTH, "Padded": padded}
    run("ti_kd_step", "test_ti_kd_step", config=f"tiny {overrides}", params=params)
