# SPDX-License-Identifier: Apache-2.0
"""`ti_woop_pipe` takes a test a cycle, is the model, and lets no ray between triangles."""

from math import cos, sin

import cocotb
import pytest
from agents.bench import run, start
from agents.fixed_latency import replay
from models.numbers import hexed, numbers
from models.payload import payloads
from models.rays import operands, shear_of
from models.scene import Scene, rays_through, soup

FORMATS = ["", "exp_bits=7 frac_bits=16", "exp_bits=5 frac_bits=10"]
TAG_WIDTH = 9


def case(corners, o, d):
    z, shear = shear_of(operands(o, d)["d"])
    return {"corners": corners, "o": o, "z": z, "shear": shear}


def cases(rng, count):
    """Triangles of a soup, half of them aimed at; then any bits at all."""
    n = numbers()
    scene = Scene(soup(rng, 60, size=1.0))
    for i, (o, d) in enumerate(rays_through(rng, count)):
        record = rng.randrange(scene.count)
        if i % 2:
            o, d = scene.aimed(rng, record)
        yield case(scene.corners[record][1], o, d)
    for _ in range(count):
        given = case([n.any_vec(rng) for _ in range(3)], n.any_vec(rng), n.direction(rng))
        yield {**given, "shear": n.any_vec(rng)} if rng.random() < 0.3 else given


def ports(given, rng):
    p = payloads()
    corners = sum(p.pack_vec(c) << i * p.width("vec3_t") for i, c in enumerate(given["corners"]))
    return {
        "tag_i": rng.getrandbits(TAG_WIDTH),
        "z_i": given["z"],
        "o_i": p.pack_vec(given["o"]),
        "shear_i": p.pack_vec(given["shear"]),
        "corners_i": corners,
    }


def reader(dut):
    def read():
        edges = None
        if dut.keep_o.value == 1:
            edges = payloads().unpack("edges_t", int(dut.edges_o.value))
            edges = edges["weight"], edges["z"], edges["sz"]
        return int(dut.tag_o.value), edges

    return read


def expected(given):
    edges = numbers().model("edge_functions", *(given[k] for k in ("corners", "o", "z", "shear")))
    return edges and (*(tuple(part) for part in edges), given["shear"][2])


async def kept(dut, rng, todo, gap=lambda: False):
    """Run the cases; what is kept of each."""
    beats = [ports(given, rng) for given in todo]
    sent, got = await replay(dut, beats, gap=gap, read=reader(dut))
    assert [cycle for cycle, _ in got] == [cycle + int(dut.Latency.value) for cycle in sent]
    for given, beat, (_, result) in zip(todo, beats, got, strict=True):
        want = beat["tag_i"], expected(given)
        assert result == want, f"{hexed(given)}: want {hexed(want)}, got {hexed(result)}"
    return [result[1] for _, result in got]


@cocotb.test()
@cocotb.parametrize(p_gap=[0.0, 0.5])
async def does_what_the_model_does(dut, p_gap):
    rng = await start(dut)
    got = await kept(dut, rng, list(cases(rng, 1500)), lambda: rng.random() < p_gap)
    assert 100 < sum(k is not None for k in got) < len(got) - 100


@cocotb.test()
async def no_ray_passes_between_the_triangles_of_a_vertex(dut):
    """A fan that surrounds the ray: aimed at the vertex and at its edges, some triangle is kept."""
    rng = await start(dut)
    n = numbers()
    todo, fans = [], []
    for _ in range(300):
        spokes = rng.randint(3, 7)
        hub = [rng.uniform(-1, 1) for _ in range(3)]
        far = [rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4), rng.uniform(2, 30)]
        turn = rng.uniform(0, 6)
        rim = [ring_point(hub, turn + 6.2831853 * i / spokes, rng) for i in range(spokes)]
        goal = hub
        if rng.random() < 0.7:
            end, part = rng.choice(rim), rng.random()
            goal = [h + part * 0.9 * (e - h) for h, e in zip(hub, end, strict=True)]
        o = n.vec(h - f for h, f in zip(hub, far, strict=True))
        d = n.vec(g - n.float(x) for g, x in zip(goal, o, strict=True))
        corners = [n.vec(p) for p in (hub, *rim)]
        for i in range(spokes):
            todo.append(case([corners[0], corners[1 + i], corners[1 + (i + 1) % spokes]], o, d))
        fans.append(spokes)

    got = iter(await kept(dut, rng, todo))

    for spokes in fans:
        hits = [next(got) for _ in range(spokes)]
        assert any(hit is not None for hit in hits)


def ring_point(hub, angle, rng):
    """About a unit from the hub, across z; the fan faces -z."""
    reach = rng.uniform(0.8, 1.2)
    x, y = reach * cos(angle), reach * sin(angle)
    return [hub[0] + x, hub[1] + y, hub[2] + rng.uniform(-0.2, 0.2)]


@pytest.mark.parametrize("overrides", FORMATS)
def test_ti_woop_pipe(overrides):
    config = f"tiny triangle_test=woop {overrides}"
    run("ti_woop_pipe", "test_ti_woop_pipe", config=config, TagWidth=TAG_WIDTH)
