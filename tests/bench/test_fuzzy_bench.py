"""The fuzzy rows of the bench compare like with like: C by hand and the peers give our outputs."""

from itertools import product

import numpy as np
import pytest

from leadscrew.bench import fuzzy, measuring, probes
from leadscrew.bench.yardstick import NoCompilerError
from leadscrew.fuzzy.evaluate import compiled
from tests.fuzzy.systems import mamdani, sugeno
from tests.tools import missing

POINTS = 500


def visited(count):
    """The points of the loop."""
    at, seen = np.zeros(2), []
    for _ in range(count):
        at = at + np.array([probes.STRIDE_X, probes.STRIDE_Y])
        at = np.where(at > 1.0, at - 2.0, at)
        seen.append(at)
    return np.array(seen)


@pytest.mark.parametrize(("form", "by_hand"), [(k, n) for k, names in fuzzy.BY_HAND.items() for n in names])
def test_c_by_hand_does_what_our_loop_does(form, by_hand):
    try:
        library, numbers = fuzzy.by_hand()
    except NoCompilerError as why:
        missing("gcc", str(why))
    system = fuzzy.systems()[form]
    theirs = getattr(library, f"fuzzy_{by_hand}")(numbers, POINTS)
    assert theirs == pytest.approx(compiled(system).many(visited(POINTS)).sum(), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["sugeno", "exact"])
def test_the_loop_asks_the_system_at_every_point(form):
    system = fuzzy.systems()[form]
    live = measuring.single(fuzzy.in_a_loop(system), POINTS)()
    assert live.values()["plant.sum"] == pytest.approx(compiled(system).many(visited(POINTS)).sum(), rel=1e-12)


@pytest.mark.slow
def test_the_systems_are_those_of_the_tests():
    at = np.random.default_rng(0).uniform(-1.0, 1.0, (50, 2))
    for ours, other in ((fuzzy.mamdani("midpoint"), mamdani()), (fuzzy.sugeno(), sugeno())):
        np.testing.assert_allclose(compiled(ours).many(at), compiled(other).many(at), atol=1e-13)
    assert len(fuzzy.large().rules) == 540


@pytest.mark.parametrize(
    ("peer", "form"),
    [*product(("pyfuzzylite", "simpful"), ("sugeno", "sampled")), ("skfuzzy", "sampled")],  # has no Takagi-Sugeno
)
def test_peers_evaluate_the_same_system(peer, form):
    at = np.random.default_rng(0).uniform(-0.95, 0.95, (6, 2))
    try:
        found = fuzzy.ask(peer, fuzzy.systems()[form], at.tolist(), 6)
    except fuzzy.Missing as why:
        missing("peers", str(why))
    loose = 2e-3 if form == "sampled" and peer != "pyfuzzylite" else 1e-12
    np.testing.assert_allclose(found.outputs[:, 0], compiled(fuzzy.systems()[form]).many(at), atol=loose)
    assert found.ns > 0.0 and (found.many_ns is None) == (peer != "pyfuzzylite")


def test_fuzzylite_evaluates_the_same_system():
    at = np.random.default_rng(0).uniform(-1.0, 1.0, (20, 2))
    try:
        found = fuzzy.fuzzylite(fuzzy.systems()["sampled"], at.tolist())
    except fuzzy.Missing as why:
        missing("fuzzylite", str(why))
    np.testing.assert_allclose(found.outputs[:, 0], compiled(fuzzy.systems()["sampled"]).many(at), atol=1e-12)


def test_a_system_that_a_peer_cannot_take_is_said():
    with pytest.raises(fuzzy.Missing, match="only triangles or constants"):
        fuzzy.describe(fuzzy.large())


def test_rows_of_a_file_name_what_they_measure(monkeypatch):
    def nowhere(*_):
        raise fuzzy.Missing("not installed: make peers")

    monkeypatch.setattr(fuzzy, "ask", nowhere)
    monkeypatch.setattr(fuzzy, "fuzzylite", nowhere)
    rows = fuzzy.bench_file(mamdani(), points=2000, rounds=1)
    assert [r["what"] for r in rows[1:3]] == [
        "49 rules, one evaluation from Python",
        "49 rules, a point of 2,000 in arrays, one thread",
    ]
    assert all(r["value"] > 0.0 for r in rows[1:3])
    assert {r["remark"] for r in rows[3:]} == {"not installed: make peers"}
