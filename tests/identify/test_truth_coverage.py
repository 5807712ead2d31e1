"""Acceptance of identification: true parameters lie within the stated 95 % intervals, on random axes.

The axes, their noise and quantisation are those of `axis_truth.py`, simulated by NumPy alone. What counts is what the
fit says it knows (`told`); that it says so of what the logs excite is asked too, or saying nothing would pass.
"""

import math
from types import SimpleNamespace

import pytest

from leadscrew.identify.axis.result import AxisFit
from leadscrew.identify.estimation import Parameter
from leadscrew.util.errors import DataError
from tests.budget import WHOLE
from tests.identify.axis_coverage import shares, statements, table
from tests.identify.axis_truth import Truth, truth, truths

SEEDS = tuple(range(1032, 1132 if WHOLE else 1072))
"""Nobody looked at these while the fit was made; 0 to 99 are those that its floors were set on."""


def as_said(low, high):
    """A fit of made-up values: what `statements` reads."""
    one = Parameter(0.5 * (low + high), "", low, high, "fitted", True)
    keys = [f"friction.{s}.{n}" for s in ("forward", "backward") for n in ("coulomb", "viscous")]
    offset = Parameter(0.0, "N", math.nan, math.nan, "fixed", False, "not identifiable")
    return SimpleNamespace(parameters={"mass": one, "offset": offset, **dict.fromkeys(keys, one)}, symmetric=False)


@pytest.mark.slow
def test_the_count_itself_knows_inside_from_outside_and_an_offset_from_friction():
    t = truth(3)
    assert not t.symmetric and t.values["offset"] != 0.0
    wide = statements(t, as_said(-1e9, 1e9))
    assert all(r.inside for r in wide if r.how == "fitted")
    narrow = statements(t, as_said(1e8, 1e9))
    assert not any(r.inside for r in narrow)
    truths_of = {r.key: r.truth for r in wide}
    ahead, back = (t.values[f"friction.{s}.coulomb"] for s in ("forward", "backward"))
    # with the offset fixed at 0 it is in the friction of both directions, and their sum is what it was
    assert truths_of["friction.forward.coulomb"] == pytest.approx(ahead + t.values["offset"])
    assert truths_of["friction.backward.coulomb"] == pytest.approx(back - t.values["offset"])


def fitted(t: Truth) -> tuple[Truth, AxisFit | None, str]:
    """The truth of a log with its fit, or with the reason why there is none."""
    from leadscrew.identify.axis.fit import identify_axis

    try:
        return t, identify_axis(t.log()), ""
    except DataError as refusal:
        return t, None, str(refusal)


@pytest.fixture(scope="module")
def fits():
    """Each axis with its fit."""
    return [fitted(t) for t in truths(SEEDS)]


@pytest.mark.slow
def test_true_values_lie_within_the_stated_intervals(fits):
    rows = [row for t, fit, _ in fits if fit is not None for row in statements(t, fit)]
    print("\n" + table(rows))
    found = {s.group: s for s in shares(rows)}
    every = found["all"]
    assert every.told > 5 * len(SEEDS)
    assert 0.90 <= every.inside / every.told <= 0.99, table(rows)
    for group in ("mass", "coulomb", "viscous", "static", "stribeck_speed", "offset"):
        s = found[group]
        # a share of n that is truly 90 % falls below this once in a thousand times
        least = 0.90 - 3.1 * math.sqrt(0.9 * 0.1 / s.told)
        assert s.inside / s.told >= least, table(rows)
        assert abs(s.bias) < 0.5, table(rows)


@pytest.mark.slow
def test_what_a_log_excites_is_told_and_useful(fits):
    """Or a fit could be right by saying nothing."""
    rows = [row for t, fit, _ in fits if fit is not None for row in statements(t, fit)]
    missed = [t.seed for t, fit, _ in fits if fit is None and t.excites]
    assert missed == []
    for group in ("mass", "coulomb", "viscous"):
        wanted = [r for r in rows if r.wanted and r.group == group]
        assert sum(r.told for r in wanted) >= 0.9 * len(wanted), group
    found = {s.group: s for s in shares(rows)}
    assert found["mass"].width < 0.05 and found["coulomb"].width < 0.05 and found["viscous"].width < 0.1


@pytest.mark.slow
def test_what_is_fixed_never_has_an_interval_and_says_why(fits):
    for t, fit, _ in fits:
        for key, p in fit.parameters.items() if fit is not None else ():
            if p.how == "fixed":
                assert math.isnan(p.low) and math.isnan(p.high) and not p.identifiable, (t.seed, key)
                assert p.note, (t.seed, key)
            elif p.how == "fitted":
                assert p.low <= p.value <= p.high, (t.seed, key)


@pytest.mark.slow
def test_a_log_that_moves_one_way_only_does_not_tell_the_other_way():
    axes = [t for t in truths(range(1032, 1132)) if t.kind.endswith("one_way")]
    one_way = [(t, fit) for t, fit, _ in map(fitted, axes) if fit is not None]
    assert len(one_way) >= 3
    for _, fit in one_way:
        assert fit.parameters["friction.backward.coulomb"].how == "fixed"
        assert not fit.parameters["offset"].identifiable
        assert not fit.parameters["friction.forward.coulomb"].identifiable
