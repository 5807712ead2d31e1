"""The bench of self-organising networks times what it says, and its rows fit the table."""

import numpy as np
import pytest

from leadscrew.bench import FIELDS, PARTS, sofnn
from leadscrew.bench.probes import probe
from leadscrew.bench.yardstick import NoCompilerError
from leadscrew.neural.inference_net import AXIS, W0, fired
from leadscrew.neural.kalman_dense import kalman_learn_dense
from tests.tools import missing


def test_the_dense_update_that_is_timed_is_the_plain_formula():
    rng = np.random.default_rng(3)
    w, p, w2, p2 = W0.copy(), np.eye(49), W0.copy(), np.eye(49)
    for e, ec, miss in rng.uniform(-6.0, 6.0, (20, 3)):
        here = fired(AXIS, AXIS, e, ec)
        h = np.zeros(49)
        k = 7 * here.j + here.i
        h[[k, k + 1, k + 7, k + 8]] = np.outer([1 - here.nu, here.nu], [1 - here.mu, here.mu]).ravel()
        sofnn.dense_update(w, p, h, miss, 0.01, 0.05, 0.9, 6.0)
        kalman_learn_dense(w2, p2, here, miss, 0.01, 0.05, 0.9, 6.0)
    assert abs(w - w2).max() < 1e-9 and abs(p - p2).max() < 1e-9


@pytest.mark.slow
def test_the_step_that_is_timed_learns_and_the_one_in_c_does_the_same(monkeypatch):
    run = probe(sofnn.learns).run(2.0, record=("output", "controller.updates"))
    assert run["controller.updates"].mean() > 0.8
    monkeypatch.setattr(sofnn, "POINTS", 2000)
    try:
        by_hand = sofnn.by_hand()
    except NoCompilerError as error:
        missing("gcc", str(error))
    assert by_hand() == pytest.approx(run["output"].sum(), rel=1e-9)


def test_a_step_must_not_cost_more_than_a_microsecond(monkeypatch):
    told = dict.fromkeys(sofnn.BLOCKS, 300.0) | {sofnn.KALMAN: 1000.5, "C": 500.0}
    monkeypatch.setattr(sofnn, "nanoseconds", lambda rounds: told)
    rows = {r["what"]: r for r in sofnn.rows(1)}
    assert "self-organising network" in PARTS and all(tuple(r) == FIELDS for r in rows.values())
    judged = {what: r["passed"] for what, r in rows.items() if r["target"]}
    assert judged == {"Kalman, four rules, marginal cost of a step in the loop": False}
    assert rows["Kalman, four rules, the learning alone"]["value"] == 700.5
    assert rows["C by hand, four rules"]["ratio"] == pytest.approx(500.0 / 1000.5)
    monkeypatch.setattr(sofnn, "nanoseconds", lambda rounds: told | {"C": None, sofnn.KALMAN: 1000.0})
    rows = {r["what"]: r for r in sofnn.rows(1)}
    assert rows["C by hand, four rules"]["value"] is None and rows["C by hand, four rules"]["remark"] == "no gcc"
    assert rows["Kalman, four rules, marginal cost of a step in the loop"]["passed"] is True
