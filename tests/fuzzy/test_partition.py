"""Triangular partitions: memberships by hand, sums of one, and the interval that a step finds."""

import numpy as np
import pytest

from leadscrew.fuzzy.inference import axis, inside_universe, interval_index, upper_membership
from leadscrew.fuzzy.partition import Partition
from leadscrew.util.errors import ValueRefused

SIX = Partition((-1.0, -0.67, -0.33, 0.33, 0.67, 1.0), ("NB", "NM", "NS", "PS", "PM", "PB"))


def test_memberships_are_those_of_the_papers_first_sample():
    assert SIX.memberships(-0.932)[:3] == pytest.approx([0.794, 0.206, 0.0], abs=5e-4)


def test_memberships_sum_to_one_everywhere_and_hold_beyond_the_ends():
    x = np.linspace(-1.5, 1.5, 301)
    assert SIX.memberships(x).sum(axis=1) == pytest.approx(np.ones(301))
    assert SIX.memberships(7.0).tolist() == [0, 0, 0, 0, 0, 1]


def test_half_way_between_two_peaks_is_a_tie_whatever_the_rounding():
    rng = np.random.default_rng(0)
    for _ in range(50):
        c = np.cumsum(rng.uniform(0.01, 1.0, 4))
        found = Partition(tuple(c), ("a", "b", "c", "d")).winners(0.5 * (c[:-1] + c[1:]))
        assert found.index.tolist() == [0, 1, 2] and found.tied.all()
        assert not Partition(tuple(c), ("a", "b", "c", "d")).winners(c).tied.any()


def test_zero_is_a_tie_between_the_two_small_sets():
    zero = SIX.winner(0.0)
    assert zero.tied and SIX.labels[zero.index] == "NS" and zero.membership == 0.5
    assert not SIX.winner(0.01).tied


def test_a_contracted_universe_keeps_the_memberships():
    assert SIX.contracted(0.2873).memberships(-0.25 * 0.2873) == pytest.approx(SIX.memberships(-0.25))


@pytest.mark.parametrize("centres", [(-1.0, 1.0), (-1.0, -0.67, -0.33, 0.33, 0.67, 1.0), tuple(np.linspace(0, 3, 13))])
def test_the_steps_interval_and_membership_agree_with_the_whole_partition(centres):
    a, sets = axis(centres), Partition(tuple(centres), tuple("x" * len(centres)))
    for x in np.concatenate([np.linspace(-1.3, 3.3, 97), centres]):
        held = inside_universe(a, x)
        i = interval_index(a, held)
        mu = np.zeros(len(centres))
        mu[i], mu[i + 1] = 1.0 - upper_membership(a, i, held), upper_membership(a, i, held)
        assert mu == pytest.approx(sets.memberships(x), abs=1e-12)


@pytest.mark.parametrize("centres", [(1.0,), (0.0, 0.0, 1.0), (1.0, 0.0), (0.0, float("nan"), 1.0), ((0.0, 1.0),)])
def test_centres_that_make_no_partition_are_refused(centres):
    with pytest.raises(ValueRefused, match="centres"):
        axis(centres)
