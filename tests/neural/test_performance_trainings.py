"""The study's kept trainings of the performance network: what was found can be found again, and is told rightly."""

import numpy as np
import pytest

from leadscrew.neural.performance import TABLE, measured
from leadscrew.neural.safety import safety, slope_at_origin
from leadscrew.studies.sofnn_tangent import performance_runs as runs
from leadscrew.studies.sofnn_tangent.claims_performance import performance_claims
from leadscrew.studies.sofnn_tangent.claims_performance_training import performance_training_claims
from leadscrew.studies.sofnn_tangent.performance_facts import nearest_plane, rises, uneven_pairs

DIGEST_PAIRS = {
    (0, 3), (0, 4), (0, 5), (0, 6), (1, -6), (1, -4), (1, 3), (1, 4), (1, 5), (1, 6), (2, -4), (2, 2), (2, 4), (3, 4),
    (4, 1), (4, 2), (4, 3), (4, 4), (5, 2), (6, 2),
}  # fmt: skip
"""(EC, E) of the pairs that do not cancel."""


@pytest.fixture(scope="module")
def claims():
    return {c.id.removeprefix("sofnn_tangent."): c for c in (*performance_claims(), *performance_training_claims())}


def test_every_claim_that_asks_for_something_gets_it(claims):
    assert [c.id for c in claims.values() if c.passed is False] == []


def test_every_claim_has_a_name_of_its_own_a_source_and_a_reason():
    made = [*performance_claims(), *performance_training_claims()]
    assert len({c.id for c in made}) == len(made)
    assert all(c.source and c.reason and c.statement for c in made)


def test_the_pairs_that_do_not_cancel_are_those_counted_by_hand():
    assert {(p.ec, p.e) for p in uneven_pairs(TABLE)} == DIGEST_PAIRS
    assert all(
        p.value == TABLE[p.ec + 6, p.e + 6] and p.mirror == TABLE[6 - p.ec, 6 - p.e] for p in uneven_pairs(TABLE)
    )


def test_a_table_that_is_a_plane_has_no_faults():
    e, ec = np.meshgrid(np.arange(-6.0, 7.0), np.arange(-6.0, 7.0))
    plane = np.clip(-(0.7 * e + 0.4 * ec), -6.0, 6.0)
    found = nearest_plane(plane)
    assert (found.a, found.b, found.rmse) == pytest.approx((0.7, 0.4, 0.0), abs=1e-3)
    assert rises(plane, 0) == rises(plane, 1) == 0 and not uneven_pairs(plane)


def test_the_kept_networks_are_what_their_names_say():
    """Slopes by a difference quotient, not by the function that chose them."""
    nets = runs.nets()
    assert set(nets) == {*runs.NAMES, runs.ACCEPTED}
    slope = {n: (measured(net, 1e-5, 0.0) - measured(net, -1e-5, 0.0)) / 2e-5 for n, net in nets.items()}
    at_zero = {n: measured(net, 0.0, 0.0) for n, net in nets.items()}
    assert slope["min_rmse"] > 0.3 and slope["biased_bad_slope"] > 0.05
    assert at_zero["biased_up"] > 0.1 and at_zero["biased_down"] < -0.1
    assert at_zero["min_rmse"] == at_zero[runs.ACCEPTED] == 0.0
    for name, net in nets.items():
        assert safety(net).accepted == (name == runs.ACCEPTED)
        assert slope_at_origin(net) == pytest.approx(slope[name], abs=1e-6)


def test_no_training_of_18_weights_has_a_smaller_rmse_than_the_one_that_runs_away():
    rmse = min(r.rmse for r in runs.trainings() if r.reading == "18" and r.method != "lm_free")
    assert safety(runs.nets()["min_rmse"]).rmse == pytest.approx(rmse, abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("reading", "method", "count"),
    [("18", "ga_16x200", 6), ("25", "ga_16x200", 6), ("18", "lm", 8), ("25", "lm", 6), ("18", "ga_80x600", 3),
     ("18", "cma_48k", 1), ("18", "pymoo_80x600", 1), ("hidden_12", "lm", 2)],
)  # fmt: skip
def test_trainings_done_again_end_as_they_did(reading, method, count):
    """Median of the first seeds; another processor rounds otherwise, and a search may then end in the next valley."""
    again = [runs.row_of(reading, method, s, runs.trained(reading, method, s)) for s in range(count)]
    kept = [r for r in runs.of(reading, method) if r.seed < count]
    assert len(kept) == count
    scatter = np.std([r.rmse for r in runs.of(reading, method)], ddof=1)
    assert np.median([r.rmse for r in again]) == pytest.approx(np.median([r.rmse for r in kept]), abs=scatter)


@pytest.mark.slow
def test_the_accepted_network_can_be_trained_again():
    from leadscrew.neural.training import train

    found, kept = train(seed=0), safety(runs.accepted_net())
    assert found.safety.accepted
    assert found.safety.rmse == pytest.approx(kept.rmse, abs=0.03)
