"""A system from data in one call: what it gives, what it records, and that held-out samples stay unseen."""

import json

import numpy as np
import pytest

from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.from_data import learn, score
from leadscrew.util.errors import NameUnknown, ValueRefused

RNG = np.random.default_rng(11)
E, DE = RNG.uniform(-1.0, 1.0, (2, 900))
DATA = {"e": E, "de": DE, "u": -np.tanh(1.5 * E + 0.7 * DE), "w": np.where(E > 0, 1.0, 0.5)}


def test_the_chain_learns_a_law_and_scores_it_on_samples_it_never_saw():
    learned = learn(DATA, ["e", "de"], "u", hold_out=0.2, seed=1, units={"e": "mm"})
    assert (learned.training.samples, learned.held_out.samples) == (720, 180)
    assert learned.held_out.rmse < 0.1 < 0.5 < learned.held_out.spread
    assert learned.system.inputs[0].unit == "mm" and learned.rules.covered == 49
    text = learned.report()
    for part in (
        "e: 7 sets on",
        "by that alone",
        "49 of 49 cells covered",
        "49 of 49 rules",
        "learned from: 720",
        "held out: 180",
    ):
        assert part in text


def test_scores_are_those_of_the_system():
    learned = learn(DATA, ["e", "de"], "u", hold_out=0.3, seed=5)
    error = compiled(learned.system).many(e=E, de=DE) - DATA["u"]
    everything = score(learned.system, np.column_stack([E, DE, DATA["u"]]))
    assert everything.rmse == pytest.approx(np.sqrt(np.mean(error**2)))
    parts = [learned.training, learned.held_out]
    assert sum(s.samples * s.rmse**2 for s in parts) / 900 == pytest.approx(everything.rmse**2)
    worst = max(parts, key=lambda s: s.worst)
    assert worst.worst == abs(error).max() and abs(error[worst.worst_sample]) == worst.worst


def test_held_out_samples_change_nothing_but_their_score():
    first = learn(DATA, ["e", "de"], "u", hold_out=0.2, seed=2)
    seen = {cell.winner.sample for cell in first.rules.cells.values()}
    order = np.random.default_rng(2).permutation(900)
    held = order[:180]
    assert not seen & set(held.tolist())
    other = {**DATA, "u": DATA["u"].copy()}
    other["u"][held] = 0.5
    second = learn(other, ["e", "de"], "u", hold_out=0.2, seed=2)
    assert second.system == first.system and second.held_out != first.held_out
    assert learn(DATA, ["e", "de"], "u", hold_out=0.2, seed=3).system != first.system


def test_every_choice_is_recorded_also_those_by_default():
    plain = json.loads(json.dumps(learn(DATA, ["e"], "u", sets={"e": 5}).as_dict(), allow_nan=False))
    assert plain["choices"] == {
        "sets": {"e": 5}, "grid": "even", "accuracy": None, "reading": None, "curvature": "local",
        "percentiles": [0.0, 100.0], "symmetric": False, "ties": "drop", "complete": [], "directions": None,
        "weights": None, "rule_weights": "none", "conclude": "centres", "hold_out": 0.0, "seed": 0,
        "name": "learned", "units": None, "default": None,
    }  # fmt: skip
    assert plain["held_out"] is None and plain["system"]["rules"] == 5
    assert len(plain["learning"]["partitions"]["u"]["centres"]) == 7


@pytest.mark.slow
def test_completion_takes_symmetric_universes_only_where_it_needs_them():
    left = DATA["e"] < 0.0
    half = {n: c[left] for n, c in DATA.items()}
    bare = learn(half, ["e", "de"], "u", symmetric=True)
    assert bare.completed.missing > 10
    both = learn(half, ["e", "de"], "u", complete=["antisymmetric"])
    assert both.choices.symmetric and both.completed.missing == 0
    assert both.rules.inputs[0].labels[0] == "NB"
    assert score(both.system, np.column_stack([E, DE, DATA["u"]])).rmse < 0.12
    filled = learn(half, ["e", "de"], "u", complete=["monotone"], directions={"e": -1, "de": -1})
    assert filled.choices.symmetric is False


def test_where_no_rule_fires_the_score_says_so():
    data = {"x": np.array([0.0, 0.1, 4.9, 5.0]), "y": np.array([0.0, 0.1, 4.9, 5.0])}
    learned = learn(data, ["x"], "y", sets={"x": 6, "y": 2}, percentiles=(0.0, 100.0))
    assert learned.rules.covered == 2 and learned.training.silent == 0
    gap = np.array([[2.5, 2.5], [0.0, 1.0]])
    found = score(learned.system, gap)
    assert (found.silent, found.samples, found.worst_sample, found.worst) == (1, 2, 1, 1.0)
    assert "no rule fires at 1" in found.sentence("gap")
    assert np.isnan(score(learned.system, gap[:1]).rmse)


def test_grids_by_quantile_and_by_curvature():
    skewed = {**DATA, "e": np.sign(E) * np.abs(E) ** 3}
    by_data = learn(skewed, ["e", "de"], "u", grid="quantile").rules.inputs[0].centres
    assert by_data[4] - by_data[3] < 0.1 * (by_data[6] - by_data[5])
    learned = learn(DATA, ["e", "de"], "u", grid="curvature", accuracy=0.05, reading="full", curvature="polynomial")
    assert learned.grid is not None and learned.rules.shape == (learned.grid.sets,) * 2
    assert "read as full" in learned.report() and learned.as_dict()["grid"]["reading"] == "full"


def test_weights_come_from_a_column():
    assert learn(DATA, ["e"], "u", weights="w").rules.weighted
    with pytest.raises(ValueRefused, match=r"weights, row \d+ \(from 0\)"):
        learn({**DATA, "w": E}, ["e"], "u", weights="w", hold_out=0.1)


@pytest.mark.parametrize(
    ("inputs", "output", "choices", "said"),
    [
        (["q"], "u", {}, "no column 'q'"),
        (["e"], "e", {}, "different names"),
        ([], "u", {}, "one input at least"),
        (["e"], "u", {"guess": 1}, "no choice 'guess'"),
        (["e"], "u", {"grid": "fine"}, "even, quantile, curvature"),
        (["e"], "u", {"grid": "curvature"}, "needs an accuracy and a reading"),
        (["e"], "u", {"accuracy": 0.1}, "are for grid = 'curvature'"),
        (["e"], "u", {"hold_out": 1.0}, "allowed is 0 to 0.9"),
        (["e"], "u", {"sets": {"q": 3}}, "no variable 'q'"),
        (["e"], "u", {"complete": ["guess"]}, "no step of completion"),
        (["e"], "u", {"weights": "q"}, "no column 'q'"),
    ],
)
def test_what_makes_no_sense_is_refused(inputs, output, choices, said):
    with pytest.raises((ValueRefused, NameUnknown), match=said):
        learn(DATA, inputs, output, **choices)


def test_columns_that_make_no_table_are_refused():
    with pytest.raises(ValueRefused, match="equal, positive length"):
        learn({"e": E, "u": E[:5]}, ["e"], "u")
    with pytest.raises(ValueRefused, match=r"row 3 \(from 0\): u = nan"):
        learn({"e": E[:9], "u": [0, 1, 2, np.nan, 4, 5, 6, 7, 8]}, ["e"], "u")
    with pytest.raises(ValueRefused, match="leaves none"):
        learn({"e": [1.0], "u": [2.0]}, ["e"], "u", hold_out=0.9)
    with pytest.raises(ValueRefused, match="e: is always 1"):
        learn({"e": [1.0, 1.0], "u": [2.0, 3.0]}, ["e"], "u")


def test_a_score_needs_rows_that_fit():
    with pytest.raises(ValueRefused, match="rows of shape"):
        score(learn(DATA, ["e"], "u").system, np.zeros((3, 5)))


def test_the_score_of_a_constant_is_worked_by_hand():
    # Mean 4, squares 9 + 1 + 0 + 16: the root mean square of a constant's errors is sqrt(26 / 4).
    rows = np.column_stack([E[:4], DE[:4], [1.0, 3.0, 4.0, 8.0]])
    assert score(learn(DATA, ["e", "de"], "u").system, rows).spread == pytest.approx(np.sqrt(6.5), rel=1e-14)
