"""What the study keeps in files (tuning, settings, scans, groups of weights) is found again; pieces by hand."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from leadscrew.controllers.tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers.tangent.curvature_network import curvature_network
from leadscrew.controllers.tangent.taught_offset import taught_alone
from leadscrew.studies.sofnn_tangent import all_weights, curvature_rules, tuning, workflow
from leadscrew.studies.sofnn_tangent.cuts import rules
from leadscrew.studies.sofnn_tangent.pieces import PLACES, PLAIN, Learned, Plan, others_mean, pieces
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MATERIAL_NAMES, PERIOD_S, SEED, line
from tests.studies.tangent_lab import lab

FABRIC = Plan(1, runs=2, materials=("fabric",))
FLOWER_S = 7.91


# ---- pieces
@pytest.mark.slow
def test_a_table_from_piece_to_piece_is_the_hand_written_one():
    """Three flowers: 0.2 of the old table and 0.8 of what was sent less the reading six samples on over 0.9."""
    ours = pieces(lab(), None, FABRIC._replace(total=3, gains=PLAIN), lines=("flower",))
    table, errors = np.zeros(PLACES), []
    for piece in range(3):
        loop = lab().loop(taught_alone(table), "flower_fabric")
        run = loop.run(FLOWER_S, record=("output", "feedback"), run=2 * piece + 1)
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
    carried = pieces(lab(), curvature_feed_forward, FABRIC._replace(total=2, carry=True), lines=("flower",))
    batch = pieces(lab(), curvature_feed_forward, FABRIC, lines=("flower",))
    assert np.array_equal(carried.rms[0], batch.rms[0])
    block, errors = curvature_feed_forward, []
    for piece in range(2):
        live = lab().loop(block, "flower_fabric").using(seed=SEED).start(run=2 * piece)
        errors.append(live.advance(live.loop.periods(FLOWER_S), every=0).metrics.rms_error)
        state = rules(live)
        block = curvature_feed_forward(prior=state.weights, prior_covariance=state.covariance)
    assert carried.rms[:, 0, 0, 0].tolist() == errors
    assert np.array_equal(carried.learned.prior["flower"][0], state.weights)


def test_what_a_new_piece_starts_from_has_seen_neither_its_line_nor_its_material():
    """Every line in every material says a power of two of its own: the mean names who was asked."""
    bits = {(m, x): 2.0 ** (3 * i + k) for i, m in enumerate(MATERIAL_NAMES) for k, x in enumerate(LINES)}
    known = {m: Learned({x: np.full((2, 7), bits[m, x]) for x in LINES}, {}) for m in MATERIAL_NAMES}
    for material, own in bits:
        asked = sum(v for (m, x), v in bits.items() if m != material and x != own)
        assert np.array_equal(4.0 * others_mean(known, material, own), np.full(7, asked))


# ---- rules of the curvature
def test_the_rules_are_set_to_what_was_chosen_on_other_lines():
    chosen = curvature_rules.chosen().setting.block().params
    for name in ("k_c", "k_h", "highpass_s", "prior_covariance"):
        assert np.array_equal(getattr(chosen, name), getattr(curvature_network.params, name)), name


def next_to(name):
    """What was tried that differs from the chosen setting in one value alone: the nearest on either side."""
    best = curvature_rules.chosen().setting
    alone = [
        t
        for t in curvature_rules.kept()
        if t.setting != best and t.setting._replace(**{name: getattr(best, name)}) == best
    ]
    sides = {
        above: [t for t in alone if (getattr(t.setting, name) > getattr(best, name)) == above]
        for above in (False, True)
    }
    return [
        min(side, key=lambda t: abs(getattr(t.setting, name) - getattr(best, name))) for side in sides.values() if side
    ]


@pytest.mark.slow
def test_the_choice_is_made_again():
    """The chosen setting and its neighbours, as the file has them; the chosen one is the best of all tried."""
    own = {round(x.length) for x in curvature_rules.lines_of_choice()}
    assert len(own) == 3 and not own & {round(line(name).travel[-1]) for name in LINES}
    best, near = curvature_rules.chosen(), next_to("scale") + next_to("highpass_s")
    assert len(near) == 4 and len(curvature_rules.kept()) > 40
    for row in (best, *near):
        again = curvature_rules.tried(lab(), row.setting)
        assert (again.worst, again.mean) == pytest.approx((row.worst, row.mean), abs=1e-5)
    assert all(best.worst < row.worst for row in near)


# ---- tuning with equal effort
def test_every_law_has_had_the_same_searches_and_was_not_held_back_by_an_end_of_its_range():
    """A filter of less than a tenth of a period is none, so that its lower end holds nothing back."""
    kept = [(each.law, each.search) for each in tuning.kept()]
    assert sorted(kept) == sorted((law, s) for law in tuning.LAWS for s in tuning.SEARCHES) and tuning.TUNED_ON != SEED
    for law in tuning.LAWS:
        found = tuning.best(law)
        none = found.values.get("filter_s", 1.0) < 0.1 * PERIOD_S
        assert set(tuning.at_ends(found)) <= ({"filter_s"} if none else set()), law


@pytest.mark.slow
def test_the_kept_settings_cost_what_the_file_says():
    for law in tuning.LAWS:
        found = tuning.best(law)
        again = tuning.costs(lab(), law, {key: np.array([x]) for key, x in found.values.items()})
        assert again[0] == pytest.approx(found.cost, rel=2e-4), law


@pytest.mark.slow
def test_a_search_of_the_pid_finds_the_kept_gains_again():
    old = next(each for each in tuning.kept() if (each.law, each.search) == ("pid", 1))
    new = tuning.found_anew(lab(), "pid", 1)
    assert new.cost == pytest.approx(old.cost, rel=1e-3)
    for key in ("kp", "ki"):
        assert new.values[key] == pytest.approx(old.values[key], rel=0.05)


# ---- all groups of weights
ON_ANOTHER_PROCESSOR = {"literal, both 0.01": 1e-4, "tuned, centres 0.01": 0.05}
"""Centres that walk make much of the last bit of a texture's sines: without AVX-512 1.1e-6 and 1.9 % at worst."""


@pytest.mark.slow
@pytest.mark.parametrize("name", all_weights.VARIANTS)
def test_the_kept_table_of_all_weights_is_made_again(name):
    again = all_weights.all_weights_rms(lab(), all_weights.VARIANTS[name])
    assert again == pytest.approx(all_weights.kept()[name], rel=ON_ANOTHER_PROCESSOR.get(name, 1e-6))


# ---- scans
def test_a_piece_of_the_table_of_scans_comes_out_again():
    found = workflow.trip("rrect", "leather", "scanner", workflow.SEEDS[1], 3)
    kept = workflow.kept_table()["rrect", "leather", "scanner"][1]
    assert kept == pytest.approx([*found.errors, found.largest, found.clipped], abs=2e-4)
