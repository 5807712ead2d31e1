"""The bench of grey predictors measures predictors, and its rows fit the table."""

import pytest

from leadscrew.bench import FIELDS, PARTS, grey
from leadscrew.bench.probes import probe
from leadscrew.grey.predictors import KINDS
from leadscrew.grey.vectorised import predictions


@pytest.mark.slow
def test_the_loop_that_is_timed_predicts():
    for block, kind in ((grey.predicts(kind=KINDS["gm11"]), "gm11"), (grey.predicts(kind=KINDS["line"]), "line")):
        run = probe(block).run(0.05)
        expected = predictions(150.0 + run["command.x"], kind)
        assert run["output"] == pytest.approx(expected, rel=1e-9)


def test_gm11_must_not_cost_more_than_60_ns_a_step(monkeypatch):
    told = dict.fromkeys(grey.SHOWN, 100.0)
    monkeypatch.setattr(grey, "nanoseconds", lambda rounds: told | {"gm11": 60.0, "chain": 60.5})
    rows = {r["what"]: r for r in grey.rows(1)}
    assert len(rows) == len(grey.SHOWN) + 1 and all(tuple(r) == FIELDS for r in rows.values())
    assert "grey prediction" in PARTS
    judged = {what: r["passed"] for what, r in rows.items() if r["target"]}
    assert judged == {
        "gm11, marginal cost in the loop": True,
        "gm11, each sample waits for the last prediction": False,
    }
    assert all("60" in r["target"] for r in rows.values() if r["target"])
    assert all(r["passed"] is None for r in rows.values() if not r["target"])
