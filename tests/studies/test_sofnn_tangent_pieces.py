"""Pieces of the study sofnn_tangent: the batch against single loops, and a table written down by hand."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from leadscrew.controllers.tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers.tangent.curvature_network import curvature_network
from leadscrew.controllers.tangent.taught_offset import taught_alone
from leadscrew.studies.sofnn_tangent import recall_choice, taught
from leadscrew.studies.sofnn_tangent.lines import LAPS, MATERIAL_NAMES, line
from leadscrew.studies.sofnn_tangent.pieces import ROOM, Learned, Teaching, pieces
from leadscrew.studies.sofnn_tangent.runs import SEED, Loops, build
from leadscrew.studies.sofnn_tangent.scenarios import SCENARIOS
from leadscrew.studies.sofnn_tangent.taught import SWAP_AT, others_say

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


def test_what_a_new_piece_starts_from_has_seen_neither_its_line_nor_its_material(monkeypatch):
    """Every line in every material says a power of two of its own: the mean names who was asked."""
    bits = {(m, x): 2.0 ** (3 * i + k) for i, m in enumerate(MATERIAL_NAMES) for k, x in enumerate(LAPS)}
    monkeypatch.setattr(
        taught, "known_of", lambda loops, m, changes: Learned({x: np.full((2, 7), bits[m, x]) for x in LAPS}, {})
    )
    for material, own in bits:
        asked = sum(v for (m, x), v in bits.items() if m != material and x != own)
        assert np.array_equal(4.0 * others_say(Loops(), material, own, None), np.full(7, asked))


def test_the_rules_are_set_to_what_was_chosen_on_other_lines():
    chosen = recall_choice.chosen().setting.block().params
    for name in ("k_c", "k_h", "highpass_s", "prior_covariance"):
        assert np.array_equal(getattr(chosen, name), getattr(curvature_network.params, name)), name


@pytest.mark.slow
def test_the_choice_is_made_again():
    """The chosen setting and its neighbours, as the file has them; the chosen one is the best of all tried."""
    own = {round(line.length) for line in recall_choice.lines_of_choice()}
    assert len(own) == 3 and not own & {round(line(name).travel[-1]) for name in LAPS}
    loops, best = Loops(), recall_choice.chosen()
    near = recall_choice.next_to("scale") + recall_choice.next_to("highpass_s")
    assert len(near) == 4 and len(recall_choice.kept()) > 40
    for row in (best, *near):
        again = recall_choice.tried(loops, row.setting)
        assert again.worst == pytest.approx(row.worst, abs=1e-5) and again.mean == pytest.approx(row.mean, abs=1e-5)
    assert all(best.worst < row.worst for row in near)
