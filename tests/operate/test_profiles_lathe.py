"""What the disturbances of the lathe axis and of the turning lathe do, and that they end."""

import numpy as np
import pytest

from tests.operate.playing import loop_of, play

pytestmark = pytest.mark.slow

# ---- vud_lathe: at rest at -50 mm after 3 s


def test_go_to_steps_the_command_now_and_the_slide_arrives_within_2_um():
    run = play("vud_lathe", "go_to", 3.0, 3.0, target=-100.0)
    assert run["command"][run.at - 1] == -50.0
    assert run["command"][run.at] == -100.0
    assert np.abs(run.span("actual.position", 2.5, 3.0) + 100.0).max() < 2e-3


def test_move_to_starts_a_move_with_limits_from_the_end_of_the_last():
    loop = loop_of("vud_lathe", "ours.pd", "trapezoid_m50")
    run = play("vud_lathe", "move_to", 2.0, 2.0, loop=loop, target=30.0)
    assert run["command"][run.at - 1] == run["command"][run.at] == -50.0
    assert run["command"][-1] == pytest.approx(30.0)
    assert np.abs(np.diff(run["command"])).max() <= 0.24 * 1.001
    assert abs(run["actual.position"][-1] - 30.0) < 2e-3


def test_a_load_pulse_on_the_slide_lasts_as_long_as_asked():
    run = play("vud_lathe", "load_pulse", 3.0, 3.0, size=0.1, for_s=0.2)
    assert np.count_nonzero(run["disturbance"]) == 200
    assert set(run.span("disturbance", 0.0, 0.2)) == {0.1}
    assert 1e3 * np.abs(run.span("true_error", 0.0, 0.2)).max() > 50.0
    assert 1e3 * np.abs(run.span("true_error", 2.5, 3.0)).max() < 2.0


def test_a_load_that_stays_stays():
    run = play("vud_lathe", "load_pulse", 3.0, 2.0, size=0.1, for_s=0.0)
    assert set(run.span("disturbance", 0.0, 2.0)) == {0.1}


def test_a_slide_that_lost_half_its_speed_goes_half_as_fast():
    """Way over duty and time is the speed at full duty; the slide follows the duty by the sum of three lags."""
    loop = loop_of("vud_lathe", scenario="fig11b_step_m170")
    run = play("vud_lathe", "speed_loss", 0.001, 2.0, loop=loop, loss=50.0, for_s=0.5)
    lag = sum(run.before[f"plant.{name}_lag_s"] for name in ("pwm", "electrical", "mechanical"))
    for first, last, speed in ((0.2, 0.45, 144.5), (0.65, 0.8, 289.0)):
        way = run.span("actual.position", first, last)
        duty = np.cumsum(run["applied"]) * run.period_s
        at = run.period_s * np.arange(len(duty) + 1)
        asked = np.interp([run.at * run.period_s + x - lag for x in (first, last - run.period_s)], at[1:], duty)
        assert (way[-1] - way[0]) / (asked[0] - asked[1]) == pytest.approx(speed, rel=5e-3)
    assert run.after == run.before


def test_stiction_swallows_small_duties_and_lets_go():
    run = play("vud_lathe", "stiction", 0.5, 3.0, threshold=0.05, for_s=1.0)
    asked, given = run.span("output", 0.0, 1.0), run.span("applied", 0.0, 1.0)
    small = np.abs(asked) < 0.05
    assert small.any()
    assert not given[small].any()
    assert (given[~small] == asked[~small]).all()
    assert (run.span("applied", 1.0, 3.0) == run.span("output", 1.0, 3.0)).all()
    assert 1e3 * np.abs(run.span("true_error", 0.9, 1.0)).min() > 2.0
    assert 1e3 * np.abs(run.span("true_error", 2.5, 3.0)).max() < 2.0


@pytest.mark.parametrize(
    ("controller", "seen"), [("ours.pd", "actual.reading"), ("ours.original_fit", "actual.position")]
)
def test_noise_of_the_ruler_has_the_size_asked_for_and_ends(controller, seen):
    """Rounding to a count of q adds q / sqrt(12) to it."""
    run = play("vud_lathe", "noise", 3.0, 4.0, loop=loop_of("vud_lathe", controller), deviation=5.0, for_s=2.0)
    count = 1e3 * run.before["sensor.resolution_mm"]
    w = 1e3 * (run["feedback"] - run[seen])
    assert np.std(w[run.at : run.at + 2000]) == pytest.approx(np.hypot(5.0, count / 12**0.5), rel=0.06)
    assert np.abs(w[run.at + 2000 :]).max() <= 0.5 * count + 1e-9
    assert np.abs(w[: run.at]).max() <= 0.5 * count + 1e-9


# ---- grey_turning, noise-free: force F = K b f^P, feed v = n (F / (K b))^(1/P)


def feed(depth=1.0, rpm=1200.0, kf=2256.3, exponent=0.77):
    """Equation (1) of the paper, solved for the feed at 150 N, mm/min."""
    return rpm * (150.0 / (kf * depth)) ** (1.0 / exponent)


def cut(name, then_s=4.0, **fields):
    return play("grey_turning", name, 3.0, then_s, loop=loop_of("grey_turning", scenario="noise_free"), **fields)


def test_the_feed_before_any_disturbance_is_that_of_the_force_law():
    run = cut(None, 0.1)
    assert run["actual.feed"][-1] == pytest.approx(feed(), rel=2e-3)


@pytest.mark.parametrize("name", ("depth_step", "stock_step"))
def test_a_step_of_the_depth_comes_now_and_nowhere_else(name):
    run = cut(name, step=-0.2, for_s=0.0)
    assert (run["plant.depth"][: run.at + 1] == 1.0).all()
    assert run["plant.depth"][run.at + 1 :] == pytest.approx(0.8)
    assert run["actual.force"][run.at + 1 : run.at + 10].min() < 135.0
    assert run["actual.feed"][-1] == pytest.approx(feed(depth=0.8), rel=2e-3)
    assert run["actual.force"][-1] == pytest.approx(150.0, rel=2e-3)


def test_a_step_of_the_depth_for_a_while_is_undone():
    run = cut("stock_step", step=0.3, for_s=1.0)
    assert run.span("plant.depth", 0.1, 1.0) == pytest.approx(1.3)
    assert (run.span("plant.depth", 1.1, 4.0) == 1.0).all()
    assert run.after == run.before


def test_a_step_of_the_depth_moves_a_falling_programme_as_a_whole():
    """1, 0.8, 0.6, 0.4 mm, every 2 s, each after the slide has followed; 0.1 mm less from 3 s on."""
    loop = loop_of("grey_turning", scenario="fig9_falling_depth")
    run = play("grey_turning", "depth_step", 3.0, 5.0, loop=loop, step=-0.1, for_s=0.0)
    for second, depth in ((1.9, 1.0), (2.9, 0.8), (3.9, 0.7), (5.9, 0.5), (7.9, 0.3)):
        assert run["actual.depth"][round(second / run.period_s)] == pytest.approx(depth, abs=2e-3)


def test_a_programmed_step_is_in_the_command_of_a_controller_that_reads_it():
    loop = loop_of("grey_turning", "ours.inversion", "noise_free")
    told = play("grey_turning", "depth_step", 3.0, 1.0, loop=loop, step=-0.2, for_s=0.0)
    hidden = play("grey_turning", "stock_step", 3.0, 1.0, loop=loop, step=-0.2, for_s=0.0)
    assert told["command.depth"][told.at - 1 : told.at + 1] == pytest.approx([1.0, 0.8])
    assert (hidden["command.depth"] == 1.0).all()
    assert hidden["actual.depth"][-1] == pytest.approx(0.8)


def test_a_hard_spot_raises_the_force_by_its_share_and_ends():
    run = cut("load_pulse", size=50.0, for_s=0.2)
    assert np.count_nonzero(run["disturbance"]) == 10
    assert set(run.span("disturbance", 0.0, 0.2)) == {0.5}
    assert 190.0 < run.span("actual.force", 0.0, 0.2).max() <= 225.0
    assert run["actual.force"][-1] == pytest.approx(150.0, rel=2e-3)


def test_another_material_takes_the_feed_of_its_law():
    run = cut("material")
    assert run["actual.feed"][-1] == pytest.approx(feed(kf=1450.0, exponent=0.96), rel=5e-3)


def test_runout_swings_the_force_while_it_lasts():
    run = cut("runout", 8.0, runout=0.05, for_s=2.0)
    assert np.std(run.span("actual.force", 1.0, 2.0)) > 2.0
    assert np.std(run.span("actual.force", 6.0, 8.0)) < 0.2
    assert run.after == run.before


def test_a_slower_spindle_takes_less_feed():
    run = cut("spindle_speed", rpm=1000.0)
    assert run["actual.feed"][-1] == pytest.approx(feed(rpm=1000.0), rel=2e-3)


def test_noise_of_the_load_cell_has_the_size_asked_for_and_ends():
    run = cut("noise", 30.0, deviation=8.0, for_s=20.0)
    w = run["sensor.raw"] - run["actual.force"]
    assert np.std(w[run.at + 1 : run.at + 1000]) == pytest.approx(8.0, rel=0.08)
    assert not w[run.at + 1001 :].any()
    assert not w[: run.at - 1].any()
