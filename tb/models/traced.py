# SPDX-License-Identifier: Apache-2.0
"""What the model of the whole engine makes of rays: nodes, work, hits."""

from collections import Counter

import ti_model
from models.numbers import numbers
from models.payload import configuration
from models.rays import ray
from models.scene import rays_through

OK, INVALID_RAY, MEMORY_ERROR, WATCHDOG = range(4)
NO_PRIM = (1 << 32) - 1


def tracer(scene, depth, watchdog):
    """The model of the configuration, with a short stack and a watchdog of these sizes."""
    config = configuration()
    return ti_model.Tracer.create(
        scene.image,
        depth,
        watchdog,
        config["interval_cull"],
        config["interval_guard"],
        config["early_exit"],
        config["restart"],
        config["any_hit"],
        config["traversal"],
    )


def random_rays(rng, count):
    n = numbers()
    for o, d in rays_through(rng, count):
        tmin = n.of(rng.choice((0.0, 0.0, 0.5)))
        yield ray(o, d, tmin, rng.choice((n.inf, n.inf, n.of(rng.uniform(1, 3)))))


def trace(model, given, any_hit=0):
    """What the model makes of a ray."""
    n = numbers()
    o, d = ([n.float(x) for x in given[k]] for k in "od")
    return model.trace(o, d, n.float(given["tmin"]), n.float(given["tmax"]), bool(any_hit))


def nodes_of(traced):
    return [int(line.split()[1]) for line in traced.log]


def work_of(traced, nodes):
    """The events of the walk through `nodes`, the first of the ray, or one more than it visits."""
    leaves = [int(words[3]) if words[2] == "leaf" else None for words in map(str.split, traced.log)]
    leaves = leaves[: len(nodes)]
    left = [count for count, after in zip(leaves, nodes[1:], strict=False) if after == nodes[0]]
    return Counter(
        steps=len(nodes),
        leaves=sum(count is not None for count in leaves),
        full_leaves=sum(bool(count) for count in leaves),
        restarts=sum(count == 0 for count in left),
        restarts_after_tests=sum(bool(count) for count in left),
    )


def hit_of(traced, ray_id, any_hit):
    values = {k: getattr(traced, k) for k in ("t", "u", "v", "status")}
    found = traced.prim >= 0
    prim = traced.prim if found else NO_PRIM
    return {**values, "ray_id": ray_id, "hit": int(found), "prim": prim, "steps": traced.hit_steps}


def leaf_at_end(traced, count):
    """What the last of the first `count` nodes counts as a leaf."""
    words = traced.log[count - 1].split()
    leaf = words[2] == "leaf"
    return Counter(leaves=int(leaf), full_leaves=int(leaf and words[3] != "0"))
