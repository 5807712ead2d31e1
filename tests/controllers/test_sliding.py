"""Sliding mode against the paper's algebra, SciPy's Radau, and known errors on the three sines."""

from math import comb

import numpy as np
import pytest

from leadscrew.controllers import csmc, smc, smc_integral
from leadscrew.controllers._sliding import complementary, conventional, integral
from leadscrew.controllers._sliding.stage import SlidingParams, View, layer_slope, switching_gain
from leadscrew.kernel.block import reference
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.module import Module
from leadscrew.plants._ballscrew_stage import INERTIA, TRAVEL_MM_PER_RAD, ballscrew_stage
from leadscrew.references._motion import Motion
from leadscrew.studies.fsmc_ballscrew.tunings import SLIDING as READINGS
from leadscrew.util.errors import ValueRefused
from tests.controllers.stage_loop import UM, continuous_loop, errors_um, stage_loop

BLOCKS = {"smc": smc, "smc_integral": smc_integral, "csmc": csmc}
SIGNALS = ("true_error", "output")


def seen(e, rate, xi, acceleration=3.0, gain=2e4, slope=1e3):
    return View(0.0, 0.0, e, rate, xi, acceleration, 0.0, 0.0, gain, slope)


def test_the_law_is_the_papers_sum_of_binomials():
    """(10): y_r^(n) - sum over k < n of C(n+1, k+1) e^(k) lam^(n-k) - lam^(n+1) xi, with n = 2."""
    lam, now = 150.0, seen(2e-4, -3e-2, 5e-6)
    errors = (now.e, now.rate)
    terms = sum(comb(3, k + 1) * errors[k] * lam ** (2 - k) for k in range(2))
    assert integral.equivalent(SlidingParams(), now) == pytest.approx(3.0 - terms - lam**3 * now.xi)


def test_the_surfaces_are_the_papers_operators_on_the_integral_of_the_error():
    lam, p = 150.0, SlidingParams()
    xi = np.array([5e-6, 2e-4, -3e-2])  # the integral, the error, its rate
    s = np.dot(np.polymul([1, lam], [1, lam]), xi[::-1])
    s_c = np.dot(np.polymul([1, lam], [1, -lam]), xi[::-1])
    now = seen(2e-4, -3e-2, 5e-6)
    assert integral.surface(p, now) == pytest.approx(s)
    assert complementary.surface(p, now) == pytest.approx(s + s_c)
    assert 2.0 * conventional.surface(p, now) == pytest.approx(s + s_c)


def test_inside_the_layer_the_switching_term_is_linear_and_outside_it_is_the_gain():
    for module, block in ((integral, smc_integral), (complementary, csmc), (conventional, smc)):
        p = block.params
        free = module.law(p, seen(0.0, 1e-3, 0.0, slope=0.0))
        inside = module.law(p, seen(0.0, 1e-3, 0.0))
        assert free - inside == pytest.approx(1e3 * module.surface(p, seen(0.0, 1e-3, 0.0)))
        far = seen(0.0, -1e3, 0.0)
        assert module.law(p, far) - module.law(p, far._replace(slope=0.0)) == pytest.approx(2e4)


def test_the_switching_gain_is_the_static_bound_of_the_friction():
    p = SlidingParams(eta=20.0)
    assert switching_gain(p, 0.0) == pytest.approx(9.36 / INERTIA + 20.0)
    assert switching_gain(p, -3.0) == pytest.approx((6.24 + 3.0) / INERTIA + 20.0)
    assert layer_slope(p, 7.0) == pytest.approx(70.0) and layer_slope(smc.params, 7.0) == 4000.0


RADAU = {
    "smc": {1: (0.004029743710842942, 3.964065509212739), 250: (0.6280377391188284, -0.0002884411060242002),
            260: (0.6267715208883777, -0.249057797351012), 599: (-0.366126181558189, -3.206379532087078)},
    "smc_integral": {1: (0.004019466910657295, 3.953097249479423), 250: (0.628011666459885, -4.799674087145887e-05),
                     260: (0.6267752844966236, -0.2477219653798683), 599: (-0.3659396073460734, -3.206835604588082)},
    "csmc": {1: (0.004017374868041218, 3.950645995374751), 250: (0.6280288228019678, -0.0002345604967155101),
             260: (0.6267748835393919, -0.2482352519568717), 599: (-0.3660343124815735, -3.206622535604269)},
}  # fmt: skip
"""Angle and speed at so many ms on sin 2 pi t, all bristles at rest at t = 0: SciPy's Radau at rtol 1e-10."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "module"), [("smc", conventional), ("smc_integral", integral), ("csmc", complementary)]
)
def test_without_sampling_the_printed_law_follows_radau(name, module):
    params = BLOCKS[name].params._replace(layer_rate=0.0)
    run = continuous_loop(module.law, params, "fast", 1e-3).run(0.6, record=("plant",))
    for k, (angle, speed) in RADAU[name].items():
        assert run["plant.angle"][k] == pytest.approx(angle, abs=1e-4 / UM)
        assert run["plant.speed"][k] == pytest.approx(speed, abs=1e-6)


IDEAL = [("corrected.smc", 0.327, 0.248), ("paper.smc_integral", 0.084, 0.0114), ("paper.csmc", 0.164, 0.124)]
IDEAL_WIDE = [("corrected.smc", 0.283), ("paper.smc_integral", 0.057), ("paper.csmc", 0.142)]
IDEAL_SLOW = [("corrected.smc", 0.377), ("paper.smc_integral", 0.034), ("paper.csmc", 0.161)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "largest", "rms"), IDEAL)
def test_sampled_fast_enough_the_printed_gains_leave_the_error_of_the_ideal_law(name, largest, rms):
    run = stage_loop(READINGS[name](pieces=1), "fast", period=2e-6).run(2.0, record="true_error", every=10)
    assert errors_um(run) == (pytest.approx(largest, rel=0.005), pytest.approx(rms, rel=0.01))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "name", "largest"),
    [("wide", *row) for row in IDEAL_WIDE] + [("slow", *row) for row in IDEAL_SLOW],
)
def test_and_so_do_the_slower_sines(command, name, largest):
    run = stage_loop(READINGS[name](pieces=1), command, period=2e-6).run(8.0, record="true_error", every=10)
    # 2 %, below 50 nm 1 nm, as the reference runs have it. On 0.01 sin t the stage slips under the integral law,
    # and roundings decide how far: RK4 at 1 and 0.5 us leaves 0.0343 and 0.0346, RODAS by two orders of the same
    # additions 0.0341 and 0.0350.
    assert errors_um(run)[0] == pytest.approx(largest, rel=0.02, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "largest"), [("corrected.smc", 0.51), ("paper.csmc", 0.329)])
def test_friction_from_the_measured_speed_without_its_damping_works_when_sampled_fast(name, largest):
    block = READINGS[name](friction_from=2, pieces=0)
    run = stage_loop(block, "fast", period=2e-6).run(1.0, record="true_error", every=10)
    assert errors_um(run)[0] == pytest.approx(largest, rel=0.005)


@pytest.mark.slow
def test_friction_by_the_letter_of_the_paper_throws_the_torque_about():
    torque = {
        reading: np.abs(
            stage_loop(READINGS["paper.csmc"](friction_from=reading, pieces=0), "fast", period=1e-4).run(1.0)["output"]
        ).max()
        for reading in (1, 3)
    }
    assert torque[1] < 30.0 and torque[3] > 1000.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["corrected.smc", "paper.csmc"])
def test_the_printed_gains_fail_at_4_khz(name):
    run = stage_loop(READINGS[name], "fast").run(1.0, record=SIGNALS)
    assert errors_um(run)[0] > 10.0 and np.abs(np.diff(run["output"])).mean() > 0.5


# Boundary layers with K / phi = 4000 1/s at F_C, and for the complementary law 2 K / phi: what an encoder of 10 nm at
# 4 kHz allows. Errors: an earlier and independent simulation of ours.
LAYER = 6.24 / INERTIA / 4000.0
AT_4_KHZ = [
    (smc(layer_rate=0.0, boundary=LAYER), {"slow": (21, 14), "wide": (11.9, 9.0), "fast": (13.8, 10.4)}),
    (csmc(layer_rate=0.0, boundary=2.0 * LAYER), {"wide": (3.32, 2.18), "fast": (11.8, 8.8)}),
]


@pytest.mark.slow
@pytest.mark.parametrize(("block", "command", "known"), [(b, c, k) for b, rows in AT_4_KHZ for c, k in rows.items()])
def test_a_layer_made_for_4_khz_leaves_the_known_errors(block, command, known):
    seconds = 6.0 if command == "fast" else 4.0 * np.pi
    run = stage_loop(block, command, encoder_mm=1e-5).run(seconds, record="true_error")
    assert errors_um(run) == (pytest.approx(known[0], rel=0.02), pytest.approx(known[1], rel=0.025))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("block", "largest"), [(smc, 22.6), (csmc, 16.3), (smc_integral, 1.03)], ids=["smc", "csmc", "smc_integral"]
)
def test_the_defaults_are_quiet_at_4_khz(block, largest):
    run = stage_loop(block, "fast", encoder_mm=1e-5).run(4.0, record=SIGNALS)
    assert errors_um(run)[0] == pytest.approx(largest, rel=0.02)
    assert np.abs(np.diff(run["output"][8000:])).mean() < 0.1


@pytest.mark.slow
def test_the_integral_law_leaves_no_steady_error_and_the_conventional_one_does():
    """In fast sliding the believed viscous friction is wrong by 0.8 N m s/rad."""
    left = {}
    for name, block in BLOCKS.items():
        run = stage_loop(block, "wide", plant=ballscrew_stage).run(1.2, record="true_error")
        left[name] = UM * abs(run["true_error"][-1])
    assert left["smc_integral"] < 0.2 * left["csmc"] < 0.2 * left["smc"]


@pytest.mark.parametrize("name", list(BLOCKS))
def test_from_rest_the_first_output_after_an_align_is_the_last_one_before(name):
    block = BLOCKS[name]
    for at, feedback, output in ((0.2, 0.2 + 3e-5, 4.0), (-1.0, -1.0 - 1e-5, -7.0)):
        here = Motion(at, 0.0, 0.0)
        s = block.align(block.params, here, feedback, output)
        _, u = block.step(block.params, s, here, feedback, 2.5e-4)
        assert u == pytest.approx(output, abs=1e-9)


def test_static_friction_is_the_most_that_an_align_holds():
    here = Motion(0.0, 0.0, 0.0)
    for name in BLOCKS:
        block = BLOCKS[name]
        _, u = block.step(block.params, block.align(block.params, here, 0.0, 50.0), here, 0.0, 2.5e-4)
        assert u == pytest.approx(9.36)


@pytest.mark.parametrize("name", list(BLOCKS))
def test_another_law_takes_over_in_motion_without_a_kick(name):
    live = stage_loop(smc, "fast").start()
    before = live.advance(400)["output"]
    live = live.switch(BLOCKS[name])
    after = live.advance(400, record=SIGNALS)
    assert live.bumpless
    assert abs(after["output"][0] - before[-1]) < 4.0 and np.abs(after["output"]).max() < 25.0
    assert UM * np.abs(after["true_error"]).max() < 30.0


def test_a_positive_error_gives_a_positive_torque():
    for block in BLOCKS.values():
        _, u = block.step(block.params, block.state, Motion(1e-3, 0.0, 0.0), 0.0, 2.5e-4)
        assert block.sense == 1 and u > 0.0


def test_in_mm_it_is_the_same_motion():
    by_rad = stage_loop(csmc, "fast").run(0.5, record="actual")["actual"]
    mm = stage_loop(csmc(travel_per_rad=1.5923), "fast", plant=ballscrew_stage(travel_per_rad=1.5923))
    by_mm = mm.using({"reference.amplitude": 1.0}).run(0.5, record="actual")["actual"]
    assert by_mm / 1.5923 == pytest.approx(by_rad, abs=1e-9)


def test_at_the_torque_limit_the_integral_waits():
    block = smc_integral(max_torque=12.0, friction_from=1)
    s, far = block.state, Motion(1.0, 0.0, 0.0)
    for _ in range(400):
        s, u = block.step(block.params, s, far, 0.0, 2.5e-4)
    assert u == 12.0 and s.xi == 0.0
    s, u = block.step(block.params, s, Motion(0.0, 0.0, 0.0), 1e-6, 2.5e-4)
    assert s.xi > 0.0


def test_a_filtered_speed_decays_to_zero_and_not_to_denormal_numbers():
    block = smc(speed_filter_s=1e-3)
    s, here = block.state, Motion(1.0, 0.0, 0.0)
    for feedback in [0.0] + [1.0] * 6000:
        s, _ = block.step(block.params, s, here, feedback, 2.5e-4)
    assert s.speed == 0.0


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("smc", {"friction_from": 2, "pieces": 0, "layer_rate": 0.0, "boundary": 5.0}),
        ("smc_integral", {"friction_from": 3, "pieces": 5, "speed_filter_s": 1e-4, "max_torque": 15.0}),
        ("csmc", {}),
    ],
)
def test_all_engines_give_the_same_bits(name, changes):
    loop = stage_loop(BLOCKS[name](**changes), "fast", encoder_mm=1e-5, method="sdirk3", substeps=10)
    record = ("output", "actual", "controller")
    fast, plain = (loop.run(0.02, record=record, engine=engine) for engine in ("llvm", "python"))
    assert all(np.array_equal(fast[column], plain[column]) for column in plain.signals)


@pytest.mark.sweep
def test_a_batch_gives_the_bits_of_single_runs():
    loop = stage_loop(csmc, "fast", method="sdirk3", substeps=10)
    rates = np.linspace(1000.0, 2500.0, 18)
    batch = loop.batch(0.1, {"controller.layer_rate": rates}, record="true_error")
    for k in (0, 7, 17):
        single = loop.using({"controller.layer_rate": rates[k]}).run(0.1, record="true_error")
        assert np.array_equal(batch["true_error"][k], single["true_error"])


@reference()
def jump():
    """1 mm at once, with the derivatives of a constant."""
    return Motion(1.0 / TRAVEL_MM_PER_RAD, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "left_um"), [("smc", 67.1), ("csmc", 67.1), ("smc_integral", 0.05)])
def test_a_step_of_1_mm_arrives_as_near_as_the_law_can(name, left_um):
    """Static friction holds 9.36 N m = J lam 4000 1/s 67.1 um / 1.5923 mm; only the integral moves it from there."""
    loop = Loop(
        reference=jump, controller=BLOCKS[name](max_torque=30.0), plant=ballscrew_stage, period=2.5e-4, metrics={},
        method="rodas", rtol=1e-6, atol=1e-12,
    )  # fmt: skip
    run = loop.run(2.0, record=SIGNALS)
    assert pytest.approx(67.1, abs=0.05) == UM * 9.36 / (INERTIA * 150.0 * 4000.0)
    assert UM * abs(run["true_error"][-1]) < left_um
    assert np.abs(run["output"]).max() == 30.0


def test_a_surface_without_slope_is_refused():
    with pytest.raises(ValueRefused, match=r"lam = 0.0"):
        smc(lam=0.0)


@pytest.mark.parametrize("name", list(BLOCKS))
def test_the_align_is_inside_the_step_subset(name):
    block, module, here = BLOCKS[name], Module(), Motion(0.2, 0.1, 0.0)
    module.arguments[id(block.align), "params"] = type(block.params)
    module.arguments[id(block.align), "command"] = Motion
    translated = module.callable(block.align)
    assert module.namespace()[translated](block.params, here, 0.19, 3.0) == block.align(block.params, here, 0.19, 3.0)
