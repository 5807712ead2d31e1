"""Pieces of the study sofnn_tangent: the batch against single loops, and a table written down by hand."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from leadscrew.controllers.tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers.tangent.taught_offset import taught_alone
from leadscrew.studies.sofnn_tangent.pieces import ROOM, Teaching, pieces
from leadscrew.studies.sofnn_tangent.runs import SEED, Loops, build
from leadscrew.studies.sofnn_tangent.scenarios import SCENARIOS
from leadscrew.studies.sofnn_tangent.taught import SWAP_AT

FLOWER = {"lines": ("flower",), "materials": ("fabric",)}


@pytest.mark.slow
def test_a_table_from_piece_to_piece_is_the_hand_written_one():
    """Three flowers: 0.2 of the old table and 0.8 of what was sent less the reading six samples on over 0.9."""
    ours = pieces(Loops(), None, 3, Teaching(), runs=2, **FLOWER)
    scenario, table, errors = SCENARIOS["flower_fabric"], np.zeros(ROOM), []
    for piece in range(3):
        loop = build(taught_alone(table), scenario).using(seed=SEED)
        run = loop.run(scenario.duration_s, record=("output", "feedback"), run=2 * piece + 1)
        errors.append(run.metrics.rms_error)
        d, e = run["output"], run["feedback"]
        n = len(d)
        target = d[: n - 6] - e[6:] / 0.9
        raw = 0.2 * table[:n] + 0.8 * np.r_[target, np.full(6, target[-1])]
        outside = {"mode": "constant", "truncate": 4.0}
        table[:n] = gaussian_filter1d(raw, 1.5, **outside) / gaussian_filter1d(np.ones(n), 1.5, **outside)
        table[n:] = table[n - 1]
    assert np.allclose(ours.rms[:, 0, 0, 1], errors, atol=1e-12)
    assert np.allclose(ours.tables["flower"][0, 1], table, atol=1e-12)


@pytest.mark.slow
def test_what_is_carried_is_what_the_last_piece_ended_with():
    """Carried one by one, the first piece is that of the batch, and the second that of a loop with this prior."""
    loops = Loops()
    carried = pieces(loops, curvature_feed_forward, 2, carry=True, runs=2, **FLOWER)
    batch = pieces(loops, curvature_feed_forward, 1, runs=2, **FLOWER)
    assert np.array_equal(carried.rms[0], batch.rms[0])
    scenario = SCENARIOS["flower_fabric"]
    block, errors = curvature_feed_forward, []
    for piece in range(2):
        live = build(block, scenario).using(seed=SEED).start(run=2 * piece)
        errors.append(live.advance(live.loop.periods(scenario.duration_s), every=0).metrics.rms_error)
        state = live.program.plan.state.unpack(live.state[0].copy(), live.state[1].copy()).controller
        block = curvature_feed_forward(prior=state.weights, prior_covariance=state.covariance)
    assert carried.rms[:, 0, 0, 0].tolist() == errors
    assert np.array_equal(carried.learned.prior["flower"][0], state.weights)


@pytest.mark.slow
def test_a_changed_material_is_the_other_one_from_its_piece_on():
    loops = Loops()
    changed = pieces(loops, None, SWAP_AT, runs=2, swap=(SWAP_AT, "foam"), **FLOWER)
    foam = pieces(loops, None, 1, runs=2, lines=("flower",), materials=("foam",), first=SWAP_AT - 1)
    assert np.array_equal(changed.rms[-1], foam.rms[0])
    assert changed.rms[-2].mean() < 0.8 * foam.rms[0].mean()
