# SPDX-License-Identifier: Apache-2.0
"""`make certify`: Gappa proves the bounds of the code, and does not prove wrong ones."""

import re
import shutil
import sys
from fractions import Fraction

import bound_cases
import certify
import pytest
from bound_cases import Case
from certify import NAMED, CertifyError

pytestmark = pytest.mark.skipif(
    shutil.which("gappa") is None, reason="gappa is not installed; `make setup` installs it"
)

NEAREST = Case(8, 23, "nearest", "division")
ZERO = Case(8, 23, "zero", "division")


def main(monkeypatch, folder, *words):
    """Exit status of the script."""
    monkeypatch.setattr(sys, "argv", ["certify.py", *words, "--out", str(folder)])
    certify.certify.cache_clear()
    try:
        return certify.main()
    finally:
        certify.certify.cache_clear()


def code_says(monkeypatch, **bounds):
    """Lets the code say other bounds than its own."""
    own = bound_cases.bounds_of
    monkeypatch.setattr(bound_cases, "bounds_of", lambda case: {**own(case), **bounds})


@pytest.mark.parametrize("form", [(5, 10), (8, 23)])
def test_every_bound_of_the_code_is_proved(form):
    results = certify.rows([form], "")
    assert {r.quantity.name for r in results} == set(NAMED)
    assert [(r.quantity.name, r.case) for r in results if not r.good] == []


@pytest.mark.parametrize(
    ("name", "case"),
    [
        ("interval of a ray", NEAREST),
        ("interval_guard", NEAREST),
        ("cull, far", ZERO),
        ("static weight", NEAREST),
    ],
)
def test_a_guard_of_one_unit_less_is_not_proved(name, case):
    quantity = NAMED[name]
    units = int(quantity.used(case))
    assert certify.gappa(certify.script(quantity, case, units))[0]
    assert not certify.gappa(certify.script(quantity, case, units - 1))[0]


@pytest.mark.parametrize(
    ("name", "key", "wrong"),
    [
        ("thickness", "thickness", 16.0),
        ("interval of a ray", "outward_ulps", 3),
        ("cull, far", "cull_ulps", 2),
        ("operation", "rounding_unit", 2.0**-25),
        ("reciprocal by Newton steps", "half_ulps", 1),
        ("static detu", "static_inside", 53.0),
        ("stand-off, test", "stand_off_test", 27.0),
        ("stand-off, point", "stand_off_point", 6.0),
    ],
)
def test_a_wrong_bound_of_the_code_is_found(monkeypatch, tmp_path, capsys, name, key, wrong):
    code_says(monkeypatch, **{key: wrong})
    assert main(monkeypatch, tmp_path, "--formats", "8,23", "--only", name) == 1
    assert f"| {name} | (8,23) nearest" in capsys.readouterr().out
    table = (tmp_path / "table.md").read_text()
    assert re.search(rf"^\| {name} \| \(8,23\) nearest.*NOT PROVED \|$", table, re.MULTILINE)


def proved(text):
    good, said = certify.gappa(text)
    assert good
    return certify.found(said)


EXACT = "float<300, -900, ne>"


@pytest.mark.parametrize(
    ("name", "rounded", "exact"),
    [
        ("plane", "fl(w)", f"{EXACT}(w)"),
        ("plane", "h in [-1b-24, 1b-24]", "h in [-1b-90, 1b-90]"),
        ("plane", "t = fl(", f"t = {EXACT}("),
        ("corner", "dx = space(", f"dx = {EXACT}("),
        ("corner", "dz = space(", f"dz = {EXACT}("),
        ("corner", "y = space(sx", f"y = {EXACT}(sx"),
        ("corner", "x = space(dx -", f"x = {EXACT}(dx -"),
        ("corner", "sx = slope(", f"sx = {EXACT}("),
        ("corner", "h in [-1b-24, 1b-24]", "h in [-1b-90, 1b-90]"),
    ],
)
def test_each_rounding_counts(name, rounded, exact):
    text = certify.script(NAMED[name], NEAREST)
    assert text.count(rounded) == 1
    assert proved(text) - proved(text.replace(rounded, exact)) > Fraction(9, 10) * NEAREST.u


def test_a_hint_that_is_no_identity_is_refused():
    text = certify.script(NAMED["static det"], NEAREST)
    with pytest.raises(CertifyError, match="Warning"):
        certify.gappa(text.replace("+ dw * ((1 + e6) - 1)", "- dw * ((1 + e6) - 1)"))


def test_a_format_too_short_for_the_thickness_is_told(monkeypatch, tmp_path, capsys):
    """At (4,3) no thickness below A covers the errors."""
    assert main(monkeypatch, tmp_path, "--formats", "4,3", "--only", "thickness") == 1
    assert "NOT PROVED" in capsys.readouterr().out


def test_the_scripts_are_kept_and_run_alone(monkeypatch, tmp_path, capsys):
    assert main(monkeypatch, tmp_path, "--formats", "8,23", "--only", "cull, near") == 0
    assert "4 bounds, 4 proved" in capsys.readouterr().out
    for file in tmp_path.glob("*.g"):
        assert certify.gappa(file.read_text())[0]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--formats", "8.23"], "not E,M"),
        (["--formats", "8,24"], "not E,M"),
        (["--formats", " "], "none is named"),
        (["--only", "nothing"], "no such quantity"),
    ],
)
def test_bad_input_is_told_and_nothing_is_written(monkeypatch, tmp_path, words, sentence):
    folder = tmp_path / "out"
    with pytest.raises(CertifyError, match=sentence):
        main(monkeypatch, folder, *words)
    assert not folder.exists()
