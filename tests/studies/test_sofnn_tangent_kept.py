"""What the study keeps in files (tuning, settings, scans, groups of weights) is found again; pieces by hand."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from leadscrew import controller_file, resolve
from leadscrew.controllers._tangent.curvature_feed_forward import curvature_feed_forward
from leadscrew.controllers._tangent.curvature_network import curvature_network
from leadscrew.controllers._tangent.taught_offset import taught_alone
from leadscrew.kernel.parameters import checked_replace
from leadscrew.studies.sofnn_tangent import all_weights, curvature_rules, scenarios, tuning, workflow
from leadscrew.studies.sofnn_tangent.cuts import rules
from leadscrew.studies.sofnn_tangent.delayed_pd import delayed_pd
from leadscrew.studies.sofnn_tangent.pieces import PLACES, PLAIN, Learned, Plan, others_mean, pieces
from leadscrew.studies.sofnn_tangent.scenarios import LINES, MATERIAL_NAMES, PERIOD_S, line
from leadscrew.studies.tuned import FOLDER
from leadscrew.tangent.piece_learning import next_offsets
from leadscrew.tune.space import Space
from leadscrew.tune.tuner import at_ends, training
from leadscrew.util.errors import ValueRefused
from tests.studies.tangent_lab import lab

STUDY = resolve.study("sofnn_tangent")
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
        run = loop.run(FLOWER_S, record=("output", "feedback"), replicate=2 * piece + 1)
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
        live = lab().loop(block, "flower_fabric").using(seed=scenarios.SEED).start(replicate=2 * piece)
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
def test_every_law_has_had_the_same_search_and_was_not_held_back_by_an_end_of_its_range():
    """Only an end that is the block's own limit may be reached."""
    files = sorted((STUDY.folder / FOLDER).glob("*.toml"))
    assert {f"tuned.{file.stem}" for file in files} == {name for name in STUDY.controllers if name.startswith("tuned.")}
    for file in files:
        found = controller_file.read(file)
        own = {"optimiser": "cma", "budget": 1000, "evaluations": 1000, "seed": tuning.SEED, "plants": tuning.PLANTS}
        assert {key: found.tuning[key] for key in own} == own, file.stem
        assert found.tuning["scenarios"] == [f"{name}_fabric" for name in tuning.LINES_TUNED]
        assert Space.of(found.tuning["over"]["plant"]["material"]).items == tuple(
            (key.removeprefix("plant.material."), dist) for key, dist in tuning.OVER.items
        )
        vary = Space.of({f"controller.{key}": text for key, text in found.tuning["vary"]["controller"].items()})
        ends = at_ends(vary, found.changes)
        assert all(" is at the upper end" in end and end.split(" ")[0] in AT_THE_LIMIT for end in ends), ends


AT_THE_LIMIT = {"controller.k_d": 15.0, "controller.forgetting": 1.0}
"""Upper ends of ranges that are the largest value of their block."""


@pytest.mark.parametrize(("name", "key"), [("corrected.sofc", "k_d"), ("ours.curvature_feed_forward", "forgetting")])
def test_the_ends_that_are_reached_are_the_limits_of_the_blocks(name, key):
    params = STUDY.controller(name).params
    with pytest.raises(ValueRefused):
        checked_replace(params, {key: 1.001 * AT_THE_LIMIT[f"controller.{key}"]}, where="here")


def test_the_linear_law_does_what_its_equation_says():
    """The block against a loop over its equation, past its limit and with an offset from before the start."""
    rng = np.random.default_rng(3)
    e = 8.0 * rng.standard_normal(60)
    block = delayed_pd(share=0.9, kp=0.6, kd=0.8, delay=3)
    got, state = [], block.state._replace(sent=np.zeros_like(block.state.sent))
    for x in e:
        state, offset = block.step(block.params, state, 0.0, -x, PERIOD_S)
        got.append(offset)
    sent, last, d = [0.0] * 3, 0.0, []
    for x in e:
        d.append(min(max(0.9 * sent[-3] + 0.6 * x + 0.8 * (x - last), -15.0), 15.0))
        sent.append(d[-1])
        last = x
    assert np.abs(d).max() == 15.0 and got == pytest.approx(d, abs=1e-12)


def test_the_third_piece_of_a_table_is_what_three_pieces_by_hand_give():
    plants = {key: column[:2] for key, column in training(tuning.OVER, tuning.PLANTS, tuning.SEED).items()}
    setting = {"gain": 0.7, "lead": 5.0, "width": 1.0, "plant_gain": 0.8}
    found = tuning.third_piece(lab(), "table", {k: np.array([0.1, v]) if k == "gain" else np.array([v, v])
                                                for k, v in setting.items()}, plants, "flower", noise=7)  # fmt: skip
    table = np.zeros(PLACES)
    for piece in range(3):
        loop = (
            lab().loop(taught_alone(table), "flower_fabric").using({key: column[1] for key, column in plants.items()})
        )
        run = loop.run(FLOWER_S, replicate=7 + 4 * piece + 3)
        after = next_offsets(table[: len(run["output"])], run["output"], run["feedback"], 0.7, 5, 1.0, 0.8)
        table = np.pad(after, (0, PLACES - len(after)), mode="edge")
    assert found["rms_error"].shape == (2, 2) and run.metrics["rms_error"] == found["rms_error"][1, 1]


@pytest.mark.sweep
@pytest.mark.parametrize("way", tuning.TABLES)
def test_a_search_finds_a_table_as_good_again(way):
    assert tuning.search(lab(), way)[0] == pytest.approx(tuning.kept(way)["cost"], rel=0.02)


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
