# SPDX-License-Identifier: Apache-2.0
"""A round of the soak follows from its seed and number, and what is wrong in it is seen."""

import soak
import soak_reduce
import soak_round
from scenes.ply import ply_bytes

GOOD = {
    "check": {
        **dict.fromkeys(soak.NEVER, 0),
        "status": {"ok": 9, "invalid_ray": 1, "memory_error": 0, "watchdog": 0},
    }
}


def report(status=(), **counts):
    check = GOOD["check"] | counts
    return {"check": check | {"status": check["status"] | dict(status)}}


def test_a_round_is_a_matter_of_its_seed_and_number():
    assert soak_round.draw(1, 7, 100) == soak_round.draw(1, 7, 100)
    assert soak_round.draw(1, 7, 100) != soak_round.draw(1, 8, 100)
    assert soak_round.draw(1, 7, 100) != soak_round.draw(2, 7, 100)


def test_rounds_draw_many_machines():
    rounds = [soak_round.draw(1, number, 100) for number in range(40)]
    keys = {word.split("=")[0] for round_ in rounds for word in round_.overrides}
    assert keys == {*soak_round.SHAPES, "exp_bits", "frac_bits"}
    assert any(run.faults for round_ in rounds for run in round_.runs)
    assert len({round_.overrides for round_ in rounds}) == 40


def test_what_must_not_be_is_told():
    run, faulty = soak_round.Run("a", "b"), soak_round.Run("a", "b", faults=True)
    assert soak.verdict(run, 0, "", report()) == ""
    for name in soak.NEVER:
        assert name in soak.verdict(run, 1, "", report(**{name: 1}))
    assert "watchdog" in soak.verdict(run, 1, "", report({"watchdog": 1}))
    assert "memory_error" in soak.verdict(run, 1, "", report({"memory_error": 1}))
    assert soak.verdict(faulty, 1, "", report({"memory_error": 1}, truth_unexplained=1)) == ""
    assert "model_mismatches" in soak.verdict(faulty, 1, "", report(model_mismatches=1))
    assert "status 1" in soak.verdict(run, 1, "", report())
    assert "status -11" in soak.verdict(run, -11, "", report())
    assert "does not end" in soak.verdict(run, None, "does not end", None)


def test_a_case_gets_as_small_as_what_fails():
    def fails(some):
        return {3, 70} <= set(some)

    assert soak_reduce.fewer(100, fails, tries=1000) == [3, 70]
    assert {3, 70} <= set(soak_reduce.fewer(100, fails, tries=5))
    assert soak_reduce.fewer(1, fails) == [0]


def test_a_mesh_is_read_as_it_was_written(tmp_path):
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    triangles = [(0, 1, 2), (0, 2, 3)]
    file = tmp_path / "a.ply"
    file.write_bytes(ply_bytes(points, triangles))
    read = soak_reduce.read_ply(file)
    assert read[0].tolist() == [list(map(float, p)) for p in points]
    assert read[1].tolist() == [list(t) for t in triangles]


def test_a_log_is_read_without_the_line_that_a_kill_cut(tmp_path):
    log = tmp_path / "rounds.jsonl"
    log.write_text('{"round": 0, "seed": 1}\n{"round": 0, "seed": 2}\n{"round": 1, "se')
    assert soak.lines_of(log, 1) == [{"round": 0, "seed": 1}]
    numbers = iter(soak.Numbers({0, 1, 3}))
    assert [next(numbers) for _ in range(3)] == [2, 4, 5]
