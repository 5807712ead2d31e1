"""Fuzzy sliding mode against a fine numeric centroid, another solver's runs, and known errors on the three sines."""

from dataclasses import replace

import numpy as np
import pytest

from leadscrew import fuzzy
from leadscrew.controllers._sliding.fuzzy import (
    RULES,
    Law,
    complement,
    fsmc,
    fsmc_printed,
    fuzzy_sliding,
    sliding_system,
)
from leadscrew.controllers._sliding.integral import equivalent, surface
from leadscrew.controllers._sliding.stage import View
from leadscrew.fuzzy.inference import Axis, RuleBase, infer
from leadscrew.kernel.block import reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.module import Module
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.studies.fsmc_ballscrew.tunings import FUZZY
from leadscrew.util.errors import ValueRefused
from tests.controllers.fuzzy_stage import continuous_fuzzy, ideal, rules_law
from tests.controllers.stage_loop import UM, both, errors_um, stage_loop
from tests.fuzzy.formats_systems import shared

VECTORS = "papers/fsmc_ballscrew_vectors"
SIGNALS = ("true_error", "output")
NM = 1e-3  # um


def surface_of(rules):
    return sliding_system(RULES[rules])


# ---- the rules
@pytest.mark.parametrize(
    ("s", "s_c", "k"),
    [(0.2, 0, -0.120690), (0.2, 0.2, -0.279412), (0.5, 0.5, -0.5), (1, 1, -1), (1, 0, -0.5), (0.5, -0.5, 0),
     (0.3, -0.2, -0.044326), (7, 9, -1)],
)  # fmt: skip
def test_the_surface_has_the_values_of_a_fine_numeric_centroid(s, s_c, k):
    assert surface_of("corrected")(s=s, s_c=s_c)["k"] == pytest.approx(k, abs=6e-7)


def test_the_whole_surface_is_that_of_the_vectors():
    table = np.genfromtxt(shared(f"{VECTORS}/reference_fuzzy_surface.csv"), delimiter=",", skip_header=1)
    ours = surface_of("corrected").many(s=table[1:, :1], s_c=table[:1, 1:])
    assert np.abs(ours - table[1:, 1:]).max() < 1e-9


def test_the_printed_rules_are_the_corrected_ones_with_s_c_turned_round():
    s, s_c = np.random.default_rng(1).uniform(-1.2, 1.2, (2, 200))
    printed, corrected = surface_of("printed"), surface_of("corrected")
    assert np.array_equal(printed.many(s=s, s_c=s_c), corrected.many(s=s, s_c=-s_c))


def test_the_printed_rules_are_the_nine_of_the_paper():
    said = [str(rule.antecedent) for rule in surface_of("printed").rules]
    assert len(said) == 9
    peaks = {"N": -1.0, "Z": 0.0, "P": 1.0}
    paper = {"NP": 1.0, "NZ": 0.5, "NN": 0.0, "ZP": 0.5, "ZZ": 0.0, "ZN": -0.5, "PP": 0.0, "PZ": -0.5, "PN": -1.0}
    for sets, centre in paper.items():
        s, s_c = (peaks[name] for name in sets)
        assert surface_of("printed")(s=s, s_c=s_c)["k"] == pytest.approx(centre, abs=1e-12)


def test_the_slope_at_the_origin_depends_on_the_direction():
    k = surface_of("corrected")
    for direction, slope in (((1, 0), -0.75), ((0, 1), -0.75), ((1, 1), -2.0), ((1, -1), 0.0)):
        assert k(s=1e-6 * direction[0], s_c=1e-6 * direction[1])["k"] / 1e-6 == pytest.approx(slope, abs=1e-5)


def test_the_law_is_the_equivalent_control_and_the_scaled_fuzzy_output():
    p, now = fsmc.prepare(fsmc.params, 1e-3), View(0.0, 0.0, 2e-4, -3e-2, 5e-6, 3.0, 0.0, 0.0, 0.0, 0.0)
    found = rules_law()(p, now)
    assert isinstance(found, Law)
    assert found.s * 0.65 == pytest.approx(surface(p.stage, now))
    assert found.s_c * 2.6 == pytest.approx(complement(p.stage, now)) == pytest.approx(-3e-2 - 150.0**2 * 5e-6)
    assert found.k == pytest.approx(surface_of("corrected")(s=found.s, s_c=found.s_c)["k"])
    assert found.u - equivalent(p.stage, now) == pytest.approx(120.0 / INERTIA * found.k)


# ---- continuous time
IDEAL = [
    ("fast", "corrected", 0.0528, 0.0105), ("wide", "corrected", 0.0388, 0.0021), ("slow", "corrected", 0.0296, 0.0056),
    ("fast", "printed", 0.058, 0.0061), ("wide", "printed", 0.044, 0.0020), ("slow", "printed", 0.019, 0.0033),
]  # fmt: skip


@pytest.mark.slow
def test_without_sampling_it_follows_another_solver_on_the_wide_sine():
    """The vectors interpolate a table of 401 x 401 values of the surface; the rest of the difference is that."""
    known = np.loadtxt(shared(f"{VECTORS}/reference_fsmc_5sin.csv"), delimiter=",", skiprows=1)
    run = continuous_fuzzy(fsmc, "wide", rules_law(), 1e-2, 1e-7, 1e-12).run(5.21, record=(*SIGNALS, "plant"))
    count = len(known)
    assert -UM * run["true_error"][:count] == pytest.approx(1e3 * known[:, 1], abs=0.06 * NM)
    assert run["output"][:count] == pytest.approx(known[:, 2], abs=5e-4)
    assert run["plant.speed"][:count] == pytest.approx(known[:, 3], abs=5e-5)


NODES = np.linspace(-1.0, 1.0, 401)
WIDTHS = 1.0 / np.diff(NODES)
TABLE = sliding_system(RULES["corrected"]).many(s=NODES[:, None], s_c=NODES[None, :])


def tabled(p, now):
    """The law on a table of 401 x 401 values."""
    s, s_c = surface(p.stage, now) / p.scale_s, complement(p.stage, now) / p.scale_sc
    k = infer(RuleBase(Axis(NODES, WIDTHS), Axis(NODES, WIDTHS), TABLE), s, s_c)
    return Law(s, s_c, k, equivalent(p.stage, now) + p.fuzzy_acceleration * k)


@pytest.mark.slow
def test_and_with_the_vectors_table_to_a_hundredth_of_a_nanometre():
    known = np.loadtxt(shared(f"{VECTORS}/reference_fsmc_5sin.csv"), delimiter=",", skiprows=1)
    run = continuous_fuzzy(fsmc, "wide", tabled, 1e-2, 1e-8, 1e-13).run(5.21, record="true_error")
    assert -UM * run["true_error"][: len(known)] == pytest.approx(1e3 * known[:, 1], abs=0.01 * NM)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rules", "largest", "rms"),
    [pytest.param(*r, marks=[pytest.mark.slow] * (i > 1)) for i, r in enumerate(IDEAL)],
)
def test_without_sampling_it_leaves_the_known_errors(name, rules, largest, rms):
    block, seconds = {"corrected": fsmc, "printed": fsmc_printed}[rules], 3.0 if name == "fast" else 4.0 * np.pi
    run = continuous_fuzzy(block, name, rules_law(rules), 2e-4).run(seconds, record="true_error")
    assert errors_um(run) == (pytest.approx(largest, abs=1.5 * NM), pytest.approx(rms, abs=0.4 * NM))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "away", "near"), [("wide", 76.0, 0.101), ("slow", 192.0, 0.131)])
def test_with_equal_scales_the_clipped_corner_lets_the_stage_drift_away(name, away, near):
    """The same slopes with a universe twenty times as wide do not."""
    largest = {}
    for wider in (1.0, 20.0):
        scale = 0.65 * wider
        block = fsmc(scale_s=scale, scale_sc=scale, fuzzy_torque=120.0 * wider)
        run = continuous_fuzzy(block, name, rules_law(), 1e-3).run(4.0 * np.pi, record="true_error")
        largest[wider] = UM * np.abs(run["true_error"]).max()
    assert largest[1.0] == pytest.approx(away, rel=0.015)
    assert largest[20.0] == pytest.approx(near, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["wide", "slow"])
def test_rules_that_follow_s_in_that_corner_bring_it_back(name):
    block = fuzzy_sliding(surface_of("without_dead_corner"))(scale_s=0.65, scale_sc=0.65)
    run = continuous_fuzzy(block, name, rules_law("without_dead_corner"), 1e-3).run(4.0 * np.pi, record="true_error")
    assert UM * np.abs(run["true_error"]).max() < 0.25


@pytest.mark.slow
@pytest.mark.parametrize(("name", "largest"), [("wide", 0.070), ("fast", 0.162), ("slow", 0.111)])
def test_friction_from_the_measured_speed_makes_it_worse(name, largest):
    seconds = 3.0 if name == "fast" else 4.0 * np.pi
    run = continuous_fuzzy(fsmc(friction_from=2), name, rules_law(), 2e-4).run(seconds, record="true_error")
    assert errors_um(run)[0] == pytest.approx(largest, rel=0.01)


@reference()
def jump():
    """1 mm at once, with the derivatives of a constant."""
    return Motion(1.0 / TRAVEL_MM_PER_RAD, 0.0, 0.0)


@reference()
def quintic(t):
    """1 mm in 50 ms: 10 x^3 - 15 x^4 + 6 x^5."""
    x = min(t / 0.05, 1.0)
    far, there = 1.0 / TRAVEL_MM_PER_RAD, x * x * (1.0 - x) * (1.0 - x)
    turn = x * (1.0 - x) * (1.0 - 2.0 * x)
    return Motion(
        far * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * far * there / 0.05, 60.0 * far * turn / 0.0025
    )


def step_loop(block, command):
    plant = replace(ballscrew_stage, output=both, jacobian=None)
    return Loop(
        reference=command, controller=ideal(block, rules_law()), plant=plant, period=None, sample=1e-4, metrics={},
        rtol=1e-7, atol=1e-13,
    )  # fmt: skip


@pytest.mark.slow
def test_a_raw_step_overshoots_and_arrives_and_a_smooth_one_does_not_overshoot():
    raw = step_loop(fsmc, jump).run(0.6, record=SIGNALS)
    assert UM * abs(raw["true_error"][-1]) < 1e-6
    assert raw["output"][-1] == pytest.approx(-6.76, abs=0.01)
    assert -UM * raw["true_error"].min() == pytest.approx(251.0, abs=1.0)
    assert np.abs(raw["output"]).max() == pytest.approx(76.0, abs=0.5)
    smooth = step_loop(fsmc, quintic).run(0.6, record=SIGNALS)
    assert UM * abs(smooth["true_error"][-1]) < 1e-9
    assert -UM * smooth["true_error"].min() < 1.0 and np.abs(smooth["output"]).max() < 27.0


@pytest.mark.slow
def test_too_little_fuzzy_torque_hangs_up_microns_away():
    """K is bounded, the integral is not seen beyond it: 'stability would be guaranteed' does not hold."""
    weak = fsmc(fuzzy_torque=30.0, scale_s=0.65 / 4.0, scale_sc=0.65)
    assert 9.0 < UM * abs(step_loop(weak, quintic).run(0.6, record=SIGNALS)["true_error"][-1]) < 20.0


@pytest.mark.slow
# ---- sampled
def test_sampled_fast_enough_it_is_the_ideal_law():
    run = stage_loop(fsmc(pieces=1), "fast", period=2e-6).run(2.0, record="true_error", every=10)
    assert errors_um(run) == (pytest.approx(0.053, rel=0.015), pytest.approx(0.0105, rel=0.01))


@pytest.mark.slow
def test_the_default_scales_are_not_for_4_khz():
    run = stage_loop(fsmc, "fast").run(1.0, record=SIGNALS)
    assert errors_um(run)[0] > 10.0 and np.abs(np.diff(run["output"])).mean() > 10.0


AT_4_KHZ = [("slow", 1.9), ("wide", 0.100), ("fast", 0.76)]
"""RMS in um of an earlier and independent simulation of ours."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "rms"), AT_4_KHZ)
def test_at_4_khz_with_the_papers_lam_it_leaves_the_known_errors(name, rms):
    seconds = 4.0 if name == "fast" else 4.0 * np.pi
    run = stage_loop(FUZZY["ours.fsmc_4khz_slow"], name, encoder_mm=1e-5).run(seconds, record="true_error")
    assert errors_um(run)[1] == pytest.approx(rms, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("tuning", "largest", "rms"),
    [("ours.fsmc_4khz", 0.24, 0.078), ("ours.fsmc_printed_4khz", 0.20, 0.034)],
    ids=["corrected", "printed"],
)
def test_tuned_for_4_khz_both_rule_bases_work_and_the_printed_one_is_calmer(tuning, largest, rms):
    run = stage_loop(FUZZY[tuning], "fast", encoder_mm=1e-5).run(4.0, record=SIGNALS)
    worst, mean = errors_um(run)
    assert worst < largest and mean == pytest.approx(rms, rel=0.02)
    chatter = np.abs(np.diff(run["output"])).sum() / 4.0
    assert (60.0 < chatter < 240.0) if "printed" in tuning else (300.0 < chatter < 900.0)


# ---- as a block
@pytest.mark.parametrize("block", [fsmc, fsmc_printed], ids=["fsmc", "fsmc_printed"])
def test_from_rest_the_first_output_after_an_align_is_the_last_one_before(block):
    p = block.prepare(block.params, 2.5e-4)
    for at, feedback, output in ((0.2, 0.2 + 3e-7, 4.0), (-1.0, -1.0 - 1e-7, -7.0)):
        here = Motion(at, 0.0, 0.0)
        _, u = block.step(p, block.align(p, here, feedback, output), here, feedback, 2.5e-4)
        assert u == pytest.approx(output, abs=1e-9)


@pytest.mark.slow
def test_another_law_takes_over_in_motion_without_a_kick():
    live = stage_loop(FUZZY["ours.fsmc_4khz"], "fast").start()
    before = live.advance(400)["output"]
    live = live.switch(FUZZY["ours.fsmc_printed_4khz"])
    after = live.advance(400, record=SIGNALS)
    assert live.bumpless
    assert abs(after["output"][0] - before[-1]) < 4.0 and UM * np.abs(after["true_error"]).max() < 5.0


def test_a_positive_error_gives_a_positive_torque():
    p = fsmc.prepare(fsmc.params, 2.5e-4)
    _, u = fsmc.step(p, fsmc.state, Motion(1e-4, 0.0, 0.0), 0.0, 2.5e-4)
    assert fsmc.sense == 1 and u > 0.0


def test_in_mm_it_is_the_same_motion():
    block = FUZZY["ours.fsmc_4khz"]
    by_rad = stage_loop(block, "fast").run(0.3, record="actual")["actual"]
    mm = stage_loop(block(travel_per_rad=1.5923), "fast", plant=ballscrew_stage(travel_per_rad=1.5923))
    by_mm = mm.using({"reference.amplitude": 1.0}).run(0.3, record="actual")["actual"]
    assert by_mm / 1.5923 == pytest.approx(by_rad, abs=1e-8)


def test_at_the_torque_limit_the_integral_waits():
    block, far = fsmc(max_torque=12.0), Motion(1.0, 0.0, 0.0)
    p, s = block.prepare(block.params, 2.5e-4), block.state
    for _ in range(400):
        s, u = block.step(p, s, far, 0.0, 2.5e-4)
    assert u == 12.0 and s.xi == 0.0


@pytest.mark.sweep
@pytest.mark.parametrize(
    "block", [FUZZY["ours.fsmc_4khz"](friction_from=2), FUZZY["ours.fsmc_printed_4khz"]], ids=["fsmc", "printed"]
)
def test_all_engines_give_the_same_bits(block):
    loop = stage_loop(block, "fast", encoder_mm=1e-5, method="sdirk3", substeps=10)
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.02, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


@pytest.mark.sweep
def test_a_batch_gives_the_bits_of_single_runs():
    loop = stage_loop(FUZZY["ours.fsmc_4khz"], "fast", method="sdirk3", substeps=10)
    scales = np.linspace(105.0, 160.0, 17)
    batch = loop.batch(0.1, {"controller.scale_s": scales}, record="true_error")
    for k in (0, 7, 16):
        single = loop.using({"controller.scale_s": scales[k]}).run(0.1, record="true_error")
        assert np.array_equal(batch["true_error"][k], single["true_error"])


@pytest.mark.slow
def test_any_two_input_system_can_take_the_place_of_the_papers():
    """Here Takagi and Sugeno's with the same rules: a table of nine numbers."""
    s, s_c = surface_of("corrected").inputs
    centres = fuzzy.constants({"NB": -1.0, "NS": -0.5, "ZO": 0.0, "PS": 0.5, "PB": 1.0})
    plain = fuzzy.takagi_sugeno("plain", [s, s_c], fuzzy.Output("k", -1.0, 1.0, centres), RULES["corrected"])
    block = fuzzy_sliding(plain, "plain")(lam=400.0, scale_s=105.0, scale_sc=548.0, fuzzy_torque=300.0)
    run = stage_loop(block, "fast", encoder_mm=1e-5).run(2.0, record="true_error")
    assert errors_um(run)[0] < 0.5


def test_a_system_of_other_inputs_or_outputs_is_refused():
    s, _ = surface_of("corrected").inputs
    one = fuzzy.takagi_sugeno("one", s, fuzzy.Output("k", -1, 1, fuzzy.constants({"A": 1.0})), "if s is N then k is A")
    with pytest.raises(ValueRefused, match=r"one has 1 inputs and 1 outputs.*two inputs, s and s_c"):
        fuzzy_sliding(one)


def test_a_scale_of_zero_is_refused():
    with pytest.raises(ValueRefused, match=r"scale_s = 0.0"):
        fsmc(scale_s=0.0)


def test_the_align_is_inside_the_step_subset():
    block, module, here = fsmc, Module(), Motion(0.2, 0.1, 0.0)
    p = block.prepare(block.params, 2.5e-4)
    module.arguments[id(block.align), "params"] = type(p)
    module.arguments[id(block.align), "command"] = Motion
    translated = module.callable(block.align)
    assert module.namespace()[translated](p, here, 0.19, 3.0) == block.align(p, here, 0.19, 3.0)
