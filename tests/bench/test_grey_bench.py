"""The bench of grey predictors measures predictors, and its rows fit the table."""

import pytest

from leadscrew.bench import FIELDS, PARTS, grey
from leadscrew.bench.probes import probe
from leadscrew.grey.predictors import KINDS
from leadscrew.grey.vectorised_others import predictions


@pytest.mark.slow
def test_the_loop_that_is_timed_predicts():
    for block, kind in ((grey.predicts(kind=KINDS["gm11"]), "gm11"), (grey.predicts(kind=KINDS["line"]), "line")):
        run = probe(block).run(0.05)
        expected = predictions(150.0 + run["command.x"], kind)
        assert run["output"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
def test_a_grey_step_costs_less_than_60_ns_beside_the_same_loop_without():
    rows = grey.rows(3)
    assert "grey prediction" in PARTS and all(tuple(r) == FIELDS for r in rows)
    judged = [r for r in rows if r["target"]]
    assert [r["what"].split(",")[0] for r in judged] == ["gm11", "gm11"]
    assert all(r["passed"] == (r["value"] <= 60.0) for r in judged)
    # A loaded machine makes a step slower, never tenfold.
    assert all(0.0 < r["value"] < 600.0 for r in judged)
