"""The fuzzy force controllers: rules against 49 of them in NumPy, laws against worked numbers and recursions."""

import itertools
import math

import numpy as np
import pytest

from leadscrew import fuzzy
from leadscrew.controllers._grey_fuzzy import gpfc, pi_incremental, smith, tfc
from leadscrew.controllers._grey_fuzzy.rule_tables import SETS, STANDARD, TABLES, rough
from leadscrew.controllers._grey_fuzzy.rules_shown import active_rules, as_fuzzy_system
from leadscrew.controllers._grey_fuzzy.surface import concluded
from leadscrew.grey.predictors import FIR, GM, GM_SHIFTED, LAST, TWO_POINT
from leadscrew.studies.grey_turning.tunings import FACTORS, TUNINGS, at
from leadscrew.studies.npid_xytable.tunings import table_pid
from leadscrew.util.errors import BlockError, ValueRefused
from tests.budget import in_every_run
from tests.controllers.grey_fuzzy_loop import force_loop

DT = 0.02
S1, S2, S3 = 4.0, 1.5, 0.003
MILD = {"error_scale": S1, "change_scale": S2, "output_scale": S3}


def all_49(table, x, y, minimum):
    """Every rule, by its definition."""
    peaks = np.arange(-6.0, 7.0, 2.0)
    mu = np.array([np.interp(x, peaks, row) for row in np.eye(7)])
    nu = np.array([np.interp(y, peaks, row) for row in np.eye(7)])
    weights = np.minimum.outer(mu, nu) if minimum else np.outer(mu, nu)
    return S3 * float((weights * 2.0 * table).sum() / weights.sum())


def said(block, x, y):
    return concluded(block.prepare(block.params, DT), S1 * x, S2 * y)


def stepped(block, forces, target=150.0, state=None):
    p, state, seen = block.prepare(block.params, DT), block.state if state is None else state, []
    for y in forces:
        state, u = block.step(p, state, target, float(y), DT)
        seen.append(u)
    return np.array(seen), state


# ---- rules
@pytest.mark.parametrize("minimum", [False, True])
@pytest.mark.parametrize("name", TABLES)
def test_four_active_rules_give_what_all_49_give(name, minimum):
    block = tfc(rules=TABLES[name], inference=int(minimum), **MILD)
    for x, y in np.random.default_rng(1).uniform(-8.0, 8.0, (60, 2)):
        assert said(block, x, y) == pytest.approx(all_49(TABLES[name], x, y, minimum), abs=1e-16)


def test_a_point_worked_by_hand():
    # e = 6 N is x = 1.5: ZO 0.25, PS 0.75; ec = 0.75 N is y = 0.5: ZO 0.75, PS 0.25; consequents ZO, PS, PS, PM
    product = S3 * (0.1875 * 0 + 0.0625 * 2 + 0.5625 * 2 + 0.1875 * 4)
    minimum = S3 * (0.25 * 0 + 0.25 * 2 + 0.75 * 2 + 0.25 * 4) / 1.5
    assert said(tfc(**MILD), 1.5, 0.5) == pytest.approx(product, rel=1e-14)
    assert said(tfc(inference=1, **MILD), 1.5, 0.5) == pytest.approx(minimum, rel=1e-14)
    assert product == pytest.approx(S3 * 2.0) and minimum == pytest.approx(S3 * 2.0)


def test_inside_the_standard_table_is_a_plane_and_nowhere_far_from_the_clip():
    block = tfc(**MILD)
    for x, y in itertools.product(np.linspace(-6.0, 6.0, 49), repeat=2):
        got = said(block, x, y) / S3
        if abs(x + y) <= 4.0:
            assert got == pytest.approx(x + y, abs=1e-12)
        assert abs(got - min(6.0, max(-6.0, x + y))) <= 0.5 + 1e-12
        assert got == pytest.approx(-said(block, -x, -y) / S3, abs=1e-12)
    assert said(block, 100.0, 0.0) == pytest.approx(6.0 * S3)


def test_rough_tables_are_what_they_say():
    for seed in range(5):
        odd, free = rough(seed), rough(seed, antisymmetric=False)
        assert np.array_equal(odd, -odd[::-1, ::-1]) and odd[3, 3] == 0.0
        assert abs(odd - STANDARD).max() == 1.0 and abs(free - STANDARD).max() == 1.0
        assert not np.array_equal(free, -free[::-1, ::-1])
        assert np.array_equal(rough(seed), odd)
    assert TABLES["weak_ec"][3].tolist() == [-1, -1, 0, 0, 0, 1, 1]
    assert TABLES["dead_zone"][2:5, 2:5].tolist() == [[-2, 0, 0], [0, 0, 0], [0, 0, 2]]


# ---- for people
@pytest.mark.parametrize("minimum", [0, 1])
def test_the_toolbox_evaluates_the_same_rules_and_its_file_keeps_them(minimum, tmp_path):
    block = gpfc(inference=minimum, rules=0.9 * STANDARD, **MILD)
    system = as_fuzzy_system(block)
    assert len(system.rules) == 49 and [len(v.terms) for v in system.inputs] == [7, 7]
    fuzzy.write(system, tmp_path / "rules.fll")
    again = fuzzy.read(tmp_path / "rules.fll")
    points = np.random.default_rng(2).uniform(-8.0, 8.0, (200, 2)) * (S1, S2)
    ours = np.array([concluded(tfc.prepare(block.params, DT), *row) for row in points])
    assert np.ravel(system.many(points)) == pytest.approx(ours, abs=1e-15)
    assert np.ravel(again.many(points)) == pytest.approx(ours, abs=1e-9)


def test_active_rules_are_named_with_their_shares():
    found = active_rules(tfc(**MILD), 6.0, 0.75)
    assert [(r.error, r.change, r.consequent, r.share) for r in found] == [
        ("PS", "ZO", "PS", 0.5625), ("ZO", "ZO", "ZO", 0.1875), ("PS", "PS", "PM", 0.1875), ("ZO", "PS", "PS", 0.0625),
    ]  # fmt: skip
    assert str(found[0]) == "if e is PS and ec is ZO then u is PS: 0.56 of +6.00 mV"
    assert [r.error for r in active_rules(tfc(**MILD), 1e3, 0.0)] == ["PB"]
    assert active_rules(tfc(rules=0.5 * STANDARD, **MILD), 0.0, 3.0)[0].consequent == "ZO..PS"
    assert math.fsum(r.share for r in active_rules(tfc(inference=1, **MILD), 5.0, -2.0)) == pytest.approx(1.0)
    with pytest.raises(BlockError, match="has no rules with scaling factors"):
        active_rules(table_pid, 1.0, 0.0)
    assert SETS[0] == "NB" and SETS[6] == "PB"


# ---- the traditional controller
def test_increments_worked_by_hand():
    # errors 2, 3, 3, -1 N: du/S3 = e/S1 + ec/S2, no change in the first period
    block = tfc(lower=-1.0, **MILD)
    increments = S3 * np.array([2 / S1, 3 / S1 + 1 / S2, 3 / S1, -1 / S1 - 4 / S2])
    assert stepped(block, [148.0, 147.0, 147.0, 151.0])[0] == pytest.approx(np.cumsum(increments), rel=1e-13)
    held = stepped(tfc(upper=0.004, **MILD), [148.0, 147.0, 147.0, 151.0])[0]
    assert held == pytest.approx([S3 / 2, 0.004, 0.004, max(0.0, 0.004 + increments[3])], abs=1e-15)
    still = stepped(tfc(positional=True, lower=-1.0, **MILD), [148.0, 147.0, 147.0, 151.0])[0]
    assert still == pytest.approx(increments, rel=1e-13)


def test_near_the_set_point_the_fuzzy_controller_is_the_pi():
    forces = 150.0 + np.random.default_rng(3).uniform(-1.0, 1.0, 300)
    f = FACTORS["s6"]
    ours, theirs = (
        stepped(b, forces, state=b.align(b.prepare(b.params, DT), 150.0, 150.0, 0.3))[0]
        for b in (at(tfc, f), pi_incremental(kp=f.kp, ki=f.ki))
    )
    assert ours == pytest.approx(theirs, abs=1e-13)
    assert np.ptp(ours) > 1e-3


# ---- the grey one
def prediction(kind, window, reference):
    """Of five samples, by least squares of NumPy and the differences of the exponential."""
    if kind == LAST:
        return window[-1]
    if kind == TWO_POINT:
        return 2.0 * window[-1] - window[-2]
    if kind == FIR:
        return window[-1] + 0.5 * (window[-2] - window[-4])
    sums = np.cumsum(window)
    background = 0.5 * (sums[1:] + sums[:-1])
    (c, u), *_ = np.linalg.lstsq(np.column_stack([-background, np.ones(4)]), window[1:], rcond=None)
    return (1.0 - math.exp(c)) * (window[0] - u / c) * math.exp(-5.0 * c)


@pytest.mark.parametrize("kind", [LAST, GM, TWO_POINT, FIR])
@pytest.mark.parametrize("reading", [0, 1])
def test_the_predicted_error_and_change_go_into_the_rules(kind, reading):
    forces = 150.0 + np.cumsum(np.random.default_rng(4).uniform(-2.0, 2.5, 40))
    block = gpfc(predictor=kind, reading=reading, lower=-10.0, upper=10.0, **MILD)
    got, state = stepped(block, forces, target=160.0)
    u, before, expected = 0.0, None, []
    for k, y in enumerate(forces):
        ahead = prediction(kind, forces[k - 4 : k + 1], 160.0) if k >= 4 else y
        error = 160.0 - ahead
        change = 0.0 if before is None else error - (160.0 - y if reading else before)
        before = error
        u += all_49(STANDARD, error / S1, change / S2, False)
        expected.append(u)
    assert got == pytest.approx(expected, rel=1e-8)
    assert state.prediction == pytest.approx(ahead, rel=1e-8)


def feed_matrices():
    """The linear feed servo of ``force_loop`` over a period, by SciPy."""
    from scipy.signal import cont2discrete

    from tests.controllers.grey_fuzzy_loop import FEED

    p = FEED.params
    a, b, c, *_ = cont2discrete((p.a, np.reshape(p.b, (-1, 1)), np.reshape(p.c, (1, -1)), np.zeros((1, 1))), DT)
    return a, b[:, 0], c[0]


@pytest.mark.parametrize("reading", in_every_run(["b", "a"], ["a"]))
def test_the_whole_loop_of_the_grey_controller_is_that_of_a_linear_law(reading):
    f = FACTORS["s9_half"]
    block = at(gpfc, f, predictor=GM_SHIFTED, shift=1e6, reading=int(reading == "a"), lower=-1.0)
    run = force_loop(block, noise=0.0, target=0.5).run(4.0, record=("feedback", "output"))
    a, b, c = feed_matrices()
    x, y, ys, us, total = np.zeros(2), 0.0, [0.0] * 3, [], 0.0
    for k in range(200):
        y = 0.8 * y + 0.2 * float(c @ x)
        ys.append(y)
        y1, y3 = ys[-2], ys[-4]
        total += 0.5 - y
        full = 0.0 if k < 4 else 1.0  # before five samples nothing is predicted
        slope = 0.5 * (y1 - y3) * full
        late = sum(0.5 * (ys[j + 3 - 1] - ys[j + 3 - 3]) for j in range(4, k + 1))
        first = 0.5 - 0.0  # no change in the first period
        if reading == "b":
            u = f.ki * (total - late) + f.kp * (0.5 - y - slope - first)
        else:
            u = f.ki * (total - late) - f.kp * late
        us.append(u)
        x = a @ x + b * u
    assert np.asarray(run["output"]) == pytest.approx(np.array(us), abs=1e-7)
    assert np.asarray(run["feedback"]) == pytest.approx(np.array(ys[3:]), abs=1e-5)
    assert abs(run["feedback"][-1] - 0.5) < 0.02


# ---- the Smith predictor
def test_a_smith_predictor_that_knows_its_plant_gives_the_response_without_delay_only_later():
    """The delay is put behind the force: two periods of it."""
    plain = at(tfc, FACTORS["smith_f"])
    p, state = plain.prepare(plain.params, DT), plain.state
    block = at(smith, FACTORS["smith_f"], **{"model.delay_s": 0.04})
    q, late = block.prepare(block.params, DT), block.state
    a, b, c = feed_matrices()
    x, z, y, line = np.zeros(2), np.zeros(2), 0.0, [0.0] * 3
    free, delayed = [], []
    for _ in range(150):
        y = 0.8 * y + 0.2 * float(c @ x)
        state, u = plain.step(p, state, 150.0, y, DT)
        x = a @ x + b * u
        free.append((y, u))
        line = [0.8 * line[0] + 0.2 * float(c @ z), *line[:2]]
        late, v = block.step(q, late, 150.0, line[2], DT)
        z = a @ z + b * v
        delayed.append((line[0], v))
    assert np.array(delayed) == pytest.approx(np.array(free), rel=1e-9, abs=1e-9)
    assert free[-1][0] == pytest.approx(150.0, abs=0.01)


def test_the_model_between_two_samples_goes_by_straight_line():
    q = smith(**{"model.delay_s": 0.025}).prepare(smith(**{"model.delay_s": 0.025}).params, DT)
    state = smith.state._replace(force=10.0, force1=20.0, force2=40.0, started=1.0)
    after, _ = smith.step(q, state, 0.0, 100.0, DT)
    # no feed: m = 0.8 * 10 = 8 now; 1.25 periods ago 0.75 * 10 + 0.25 * 20 = 12.5
    assert after.error == pytest.approx(-(100.0 + 8.0 - 12.5))


# ---- all of them
@pytest.mark.parametrize(
    "name",
    ["corrected.tfc_s6", "corrected.gpfc_b_s9", "corrected.gpfc_a_s9", "paper.gpfc_printed_s9", "ours.two_point_stfc",
     "ours.smith_f", "ours.pi_stfc"],
)  # fmt: skip
def test_taking_over_keeps_the_voltage(name):
    block = TUNINGS[name]
    p = block.prepare(block.params, DT)
    for command, feedback, output in ((150.0, 150.0, 0.24), (150.0, 149.0, 0.8), (100.0, 103.0, 0.1)):
        state = block.align(p, command, feedback, output)
        assert block.step(p, state, command, feedback, DT)[1] == pytest.approx(output, abs=1e-12)


@pytest.mark.slow
def test_a_live_loop_is_switched_between_them_without_a_bump():
    live = force_loop(TUNINGS["corrected.tfc_stfc"]).start()
    before = live.advance(150)
    for name in ("corrected.gpfc_b_stfc", "ours.smith_f"):
        live = live.switch(TUNINGS[name])
        assert live.bumpless
        after = live.advance(50)
        assert abs(after["output"][0] - before["output"][-1]) < 0.002
        before = after


@pytest.mark.parametrize("name", ["corrected.tfc_s9", "ours.gm_raw_s9"])
def test_compiled_and_python_are_the_same_to_the_last_bit(name):
    loop = force_loop(TUNINGS[name])
    fast, plain = loop.run(1.5), loop.run(1.5, engine="python")
    assert all(np.array_equal(plain[s], fast[s]) for s in plain.signals)


@pytest.mark.slow
def test_a_batch_mixes_predictors_readings_and_inference_in_one_program():
    loop = force_loop(TUNINGS["corrected.gpfc_b_s9"], noise=0.0)
    kinds = {
        "controller.predictor": [0, 1, 6, 1],
        "controller.reading": [0, 0, 0, 1],
        "controller.inference": [0, 1, 0, 0],
    }
    batch = loop.batch(1.0, {k: np.array(v) for k, v in kinds.items()}, record=("output",))
    for i in range(4):
        single = loop.using({k: v[i] for k, v in kinds.items()}).run(1.0)
        assert np.array_equal(np.asarray(batch["output"])[i], np.asarray(single["output"]))
    assert np.array_equal(
        np.asarray(batch["output"])[0],
        np.asarray(force_loop(TUNINGS["corrected.tfc_s9"], noise=0.0).run(1.0)["output"]),
    )


def test_values_that_cannot_be_are_refused_in_one_sentence():
    with pytest.raises(ValueRefused, match=r"lower = 1 V, upper = 0.5 V: the lower limit must be below"):
        force_loop(tfc(lower=1.0, upper=0.5)).run(0.1)
    with pytest.raises(ValueRefused, match=r"lower = 1 V, upper = 0.5 V"):
        force_loop(pi_incremental(lower=1.0, upper=0.5)).run(0.1)
    with pytest.raises(ValueRefused, match=r"model.delay_s = 0.2 s \(smith\): allowed are up to 4 periods"):
        force_loop(smith(**{"model.delay_s": 0.2})).run(0.1)
    for key, value in (("error_scale", 0.0), ("inference", 2), ("rules", 4.0 * np.ones((7, 7)))):
        with pytest.raises(ValueRefused, match=key):
            tfc(**{key: value})
    with pytest.raises(ValueRefused, match="predictor"):
        gpfc(predictor=15)
