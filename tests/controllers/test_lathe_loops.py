"""Three loops in one controller: each is itself, they hold the lathe together, and they can be exported."""

import numpy as np
import pytest

from leadscrew.controllers._force.power_law_inversion import power_law_inversion
from leadscrew.controllers._grey_fuzzy.gpfc import gpfc
from leadscrew.controllers._lathe_loops import RemovalRate, RemovalState, lathe_loops, plan_removal, regulated
from leadscrew.export.controller import export_controller
from leadscrew.export.folder import compiler_path, verify, write
from leadscrew.export.verdict import IDENTICAL, NOT_RUN
from leadscrew.plants._turning.workpiece import Workpiece, stretches
from leadscrew.plants._turning_lathe import turning_lathe
from leadscrew.references._lathe_program import LatheCommand, LatheDrive, lathe_program
from leadscrew.sensors._lathe_sensors import LatheReading
from leadscrew.studies.grey_turning.lathe import force_law, law
from leadscrew.studies.grey_turning.tunings import TUNINGS
from leadscrew.util.errors import BlockError, ValueRefused
from tests.controllers.lathe_three_loops import falling, lathe, three
from tests.tools import missing


def alone(block, command, feedback):
    """The outputs of one controller by itself."""
    p, s, out = block.prepare(block.params, 0.02), block.state, []
    for r, y in zip(command, feedback, strict=True):
        s, u = block.step(p, s, r, y, 0.02)
        out.append(u)
    return out


@pytest.mark.slow
def test_each_loop_gives_what_its_controller_gives_alone():
    run = lathe().run(3.0)
    for axis, signal, name in (("spindle", "rpm", "ours.spindle_gpfc"), ("feed", "force", "corrected.gpfc_b_s9"),
                               ("radial", "depth", "ours.depth_gpfc")):  # fmt: skip
        block = TUNINGS[name].starting(output=8.0) if axis == "spindle" else TUNINGS[name]
        expected = alone(block, run[f"command.{signal}"], run[f"feedback.{signal}"])
        assert run[f"output.{axis}_v"] == pytest.approx(expected, abs=1e-12)


def test_a_gpfc_that_predicts_the_last_sample_is_the_tfc():
    r, y = np.full(60, 150.0), 150.0 * (1.0 - 0.9 ** np.arange(60.0)) + np.random.default_rng(1).normal(0.0, 2.0, 60)
    changes = {key.removeprefix("controller.feed."): v for key, v in force_law("corrected.tfc_s9").items()}
    assert alone(gpfc(**changes), r, y) == alone(TUNINGS["corrected.tfc_s9"], r, y)
    assert law("spindle", "tfc")["controller.spindle.predictor"] == "last"


@pytest.mark.slow
def test_speed_force_and_depth_are_held_together():
    run = lathe(noise_n=0.0, runout=0.0).run(8.0)
    late = run.time > 7.5
    for signal, target in (("rpm", 1200.0), ("force", 150.0), ("depth", 0.4)):
        assert run[f"actual.{signal}"][late] == pytest.approx(target, rel=2e-3)


@pytest.mark.slow
def test_a_controller_of_the_whole_cut_is_told_all_of_it():
    run = lathe(three(power_law_inversion(first_k=4000.0)), noise_n=0.0, runout=0.0).run(2.0)
    assert run["actual.force"][-1] == pytest.approx(150.0, rel=5e-3)


@pytest.mark.slow
def test_a_fixed_removal_rate_is_held_by_the_speed():
    """At constant force the rate is in proportion to the speed: 80 mm3/s want 80 / 92.9 of 1,200 1/min."""
    run = lathe(three(removal=RemovalRate(rate=80.0)), {}, noise_n=0.0, runout=0.0).run(12.0)
    rate = np.pi * 50.0 * run["actual.feed"][-1] / 60.0
    assert rate == pytest.approx(80.0, rel=5e-3)
    assert run["actual.force"][-1] == pytest.approx(150.0, rel=5e-3)
    assert run["actual.rpm"][-1] == pytest.approx(1200.0 * 80.0 / (np.pi * 50.0 * 35.5 / 60.0), rel=5e-3)


@pytest.mark.parametrize(
    ("force", "wanted", "fed", "rpm"),
    [
        (74.0, 36.0, 0.02, 1000.0),  # not half of 150 N: the edge is still entering, the speed stays
        (76.0, 36.0, 0.02, 1004.0),  # 36 asked, 30 cut: faster by a fifth, of which a period of 0.02 s brings 2 %
        (150.0, 24.0, 0.02, 996.0),
        (150.0, 36.0, 0.002, 1020.0),  # twelve times too little is cut: twice counts
        (150.0, 36.0, 0.2, 990.0),  # eight times too much: half counts
    ],
)
def test_the_speed_follows_the_removal_rate_only_while_half_of_the_force_or_more_is_met(force, wanted, fed, rpm):
    """A bar of 60 mm around, 0.5 mm deep, fed 0.02 mm in 0.02 s: 30 mm3/s."""
    bar = Workpiece(diameter=60.0 / np.pi)
    p = plan_removal(RemovalRate(rate=wanted, smooth_s=1e-6, work=bar), 0.02)
    seen = LatheReading(rpm=1000.0, force=force, depth=0.5, raw=force, travel=5.0, turns=0.0)
    before = RemovalState(rpm=1000.0, rate=30.0, travel=5.0 - fed)
    after = regulated(p, before, LatheCommand(1200.0, 150.0, 0.5, 0.5), seen, 0.02)
    assert after.rpm == pytest.approx(rpm)
    assert after.rate == pytest.approx(1500.0 * fed if force > 75.0 else 0.0) and after.travel == 5.0


def test_the_speed_for_a_removal_rate_stays_within_its_limits_and_counts_the_stock():
    bar = Workpiece(diameter=60.0 / np.pi, **stretches([2.0], [0.5]))  # 1 mm of depth from 2 mm on
    seen = LatheReading(rpm=1000.0, force=150.0, depth=0.5, raw=150.0, travel=5.0, turns=0.0)
    command = LatheCommand(1200.0, 150.0, 0.5, 0.5)
    for rate, limits, rpm in ((36.0, {}, 992.0), (600.0, {"highest": 1010.0}, 1010.0), (1.0, {"lowest": 995.0}, 995.0)):
        p = plan_removal(RemovalRate(rate=rate, smooth_s=1e-6, work=bar, **limits), 0.02)
        assert regulated(p, RemovalState(1000.0, 60.0, 4.98), command, seen, 0.02).rpm == pytest.approx(rpm)
    # the first cut begins at the programmed speed, and the rate is smoothed over its time: half of it in ln 2
    p = plan_removal(RemovalRate(rate=60.0, smooth_s=0.02 / np.log(2.0), work=bar), 0.02)
    first = regulated(p, RemovalState(0.0, 0.0, 4.98), command, seen, 0.02)
    assert (first.rpm, first.rate) == pytest.approx((1224.0, 30.0))


def test_what_is_no_loop_is_refused():
    with pytest.raises(BlockError, match=r"lathe_loops\(feed = turning_lathe\)"):
        lathe_loops(TUNINGS["ours.spindle_tfc"], turning_lathe, TUNINGS["ours.depth_tfc"])
    with pytest.raises(ValueRefused, match=r"removal.lowest = 900.0 .* below removal.highest = 800.0"):
        plan_removal(RemovalRate(lowest=900.0, highest=800.0), 0.02)


def test_taking_over_makes_no_jump_in_speed_and_feed():
    block = three()
    p = block.prepare(block.params, 0.02)
    command, seen = LatheCommand(1200.0, 150.0, 1.0, 1.0), LatheReading(1190.0, 140.0, 1.0, 139.0, 3.0, 40.0)
    state = block.align(p, command, seen, LatheDrive(7.9, 0.2, 0.0))
    _, out = block.step(p, state, command, seen, 0.02)
    assert out == pytest.approx((7.9, 0.2, 0.0), abs=1e-9)


@pytest.mark.slow
def test_the_encoders_give_whole_counts_and_the_mean_speed():
    loop = lathe(noise_n=0.0).using({"sensor.spindle_counts": 100.0, "sensor.depth_count_mm": 0.01})
    run = loop.run(2.5)
    counts = run["feedback.rpm"][1:] / (60.0 / (100.0 * 0.02))
    assert counts == pytest.approx(np.round(counts), abs=1e-6)
    assert len(np.unique(np.round(counts))) > 1
    turned = np.floor(100.0 * run["actual.turns"] + 0.5) / 100.0
    assert run["feedback.rpm"][1:] == pytest.approx(np.diff(turned) * 60.0 / 0.02, abs=1e-6)
    marks = 100.0 * run["feedback.depth"]
    assert marks == pytest.approx(np.round(marks), abs=1e-9)
    assert np.abs(run["feedback.depth"] - run["actual.depth"]).max() <= 0.005 + 1e-12


def test_the_programme_asks_for_no_force_before_its_time():
    p = lathe_program(**{"force_from_s": 0.5, "depth.step": -0.2, "depth.steps": 2}).params
    assert [lathe_program.step(p, t, 0.02).force for t in (0.0, 0.48, 0.5, 3.0)] == [0.0, 0.0, 150.0, 150.0]
    assert lathe_program.step(p, 1.5, 0.02) == LatheCommand(1200.0, 150.0, 1.0, 0.8, 0.5)


def test_three_voltages_go_to_c_with_the_same_bits(tmp_path):
    if compiler_path() is None:
        missing("gcc", "there is no C compiler on this machine")
    loop = falling()
    core, record = export_controller(loop, 8.0, name="ours", title="three loops")
    assert [p.key for p in core.outputs] == ["output.spindle_v", "output.feed_v", "output.radial_v"]
    write(core, record, "c99", tmp_path / "out", loop=loop)
    judged = [v for v in verify(tmp_path / "out") if v.verdict != NOT_RUN]
    assert judged and {(v.verdict, v.cycles) for v in judged} == {(IDENTICAL, 400)}
