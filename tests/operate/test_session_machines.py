"""The five machines operated by hand: the session from its script in another process; circles; bumps."""

import subprocess
import sys

import numpy as np
import pytest

from leadscrew.operate import script, session_file
from leadscrew.operate.operated import Operated, Start
from leadscrew.report import session as session_report
from leadscrew.util.errors import ValueRefused

MACHINES = {
    "vud_lathe": ("corrected.vud_beta_e", "sequence", "ours.pd"),
    "grey_turning": ("corrected.gpfc_b_s9", "fig6_fixed_depth", "ours.pi_s9"),
    "fsmc_ballscrew": ("ours.fsmc_4khz", "sine_fast", "ours.pd_dob"),
    "sofnn_tangent": ("ours.sofnn_tuned", "wave_fabric", "corrected.fnn"),
    "npid_xytable": ("corrected.npid_um", "spindle_1000", "ours.pid_ms_159"),
}


def operate(operated, other):
    """Every kind of thing that an operator does."""
    operated.advance(400)
    key, entry = next(
        (k, e) for k, e in operated.sheet.items() if k.startswith("controller.") and e.type == "float" and e.default
    )
    operated.set({key: 0.9 * entry.default})
    for disturbance in operated.profile.disturbances:
        operated.advance(137)
        operated.disturb(disturbance.name)
    operated.advance(500)
    operated.switch(other)
    operated.advance(300)
    operated.undo()
    operated.advance(300)
    operated.safe("time-out")
    operated.advance(300)


@pytest.mark.slow
@pytest.mark.parametrize("study", MACHINES)
def test_a_script_makes_the_whole_run_again_in_another_process(study, tmp_path):
    controller, scenario, other = MACHINES[study]
    operated = Operated(Start(study, controller, scenario))
    operate(operated, other)
    session = operated.session()
    assert len(session.events) > 5
    path = tmp_path / "again.py"
    script.write(session, operated.period_s, path)
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, ""), done
    assert done.stdout == f"identical: {session.periods} periods of {len(operated.columns)} signals, bit for bit\n"
    changed = path.read_text(encoding="utf-8").replace(f"period={session.events[0].period},", "period=401,", 1)
    path.write_text(changed, encoding="utf-8")
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 1 and done.stderr.startswith("not identical: "), done
    session_file.write(session, tmp_path / "s.toml")
    assert session_file.read(tmp_path / "s.toml").run(record=()).identical
    assert "every signal has the same bits" in session_report.html(session)


@pytest.mark.slow
def test_every_engine_gives_the_digest_of_the_session():
    operated = Operated(Start("vud_lathe", "corrected.vud_beta_e", "fig11a_step_m50"))
    operated.advance(100)
    operated.set({"controller.tau": 0.7})
    operated.advance(200)
    other = Operated(Start("vud_lathe", "corrected.vud_beta_e", "fig11a_step_m50", engine="python"))
    other.advance(100)
    other.set({"controller.tau": 0.7})
    other.advance(200)
    assert operated.digest == other.digest


@pytest.fixture(scope="module")
def circle():
    """Two stages on a circle."""
    return Operated(Start("fsmc_ballscrew", "ours.pid", "sine_fast", circle=True))


@pytest.mark.slow
def test_two_axes_draw_a_circle(circle):
    operated = circle.restarted()
    rows, _ = operated.advance(8000)
    at = {c: i for i, c in enumerate(operated.columns)}
    x, y = rows[:, at["command.position"]], rows[:, at["y.command.position"]]
    radius = operated.values()["reference.amplitude"]
    assert np.hypot(x, y) == pytest.approx(np.full(8000, radius), rel=1e-12)
    assert x[0] == pytest.approx(radius) and y[0] == 0.0
    drawn = np.hypot(rows[:, at["actual"]], rows[:, at["y.actual"]])[4000:]
    assert np.abs(drawn - radius).max() < 0.02 * radius
    assert operated.units["y.actual"] == "mm" and operated.columns.count("time") == 1


@pytest.mark.slow
def test_a_key_sets_both_axes_or_the_one_of_its_prefix(circle):
    operated = circle.restarted()
    operated.advance(100)
    operated.set({"controller.kp": 300.0})
    operated.set({"y.controller.kp": 250.0})
    operated.set({"x.plant.friction.coulomb": 5.0, "controller.kd": 0.6})
    assert operated.values()["controller.kp"] == 300.0 and operated.values()["y.controller.kp"] == 250.0
    operated.advance(round(0.1 / operated.period_s))
    assert [live.loop.parameters["controller.kp"] for live in operated.lives] == [300.0, 250.0]
    assert operated.lives[1].loop.parameters["plant.friction.coulomb"] != 5.0
    assert operated.values()["y.controller.kp"] == 250.0
    operated.advance(100)
    operated.set({"controller.kp": 280.0})
    assert operated.undo().new == {"x.controller.kp": 300.0, "y.controller.kp": 250.0}
    operated.switch("ours.pd_dob")
    operated.advance(100)
    operated.undo()
    assert [live.loop.parameters["controller.kp"] for live in operated.lives] == [300.0, 250.0]
    operated.safe("time-out")
    assert operated.changed() == {"x.plant.friction.coulomb": 5.0}
    operated.advance(100)
    assert operated.session().run(record=()).identical


def test_a_machine_without_a_circle_says_what_has_one():
    with pytest.raises(ValueRefused, match=r"circle: .* here the plant is lathe_servo .* choose a sine scenario"):
        Operated(Start("vud_lathe", "ours.pd", "sequence", circle=True))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("start", "key", "by"),
    [
        (Start("npid_xytable", "ours.pid_ms_159", "sine_1mm"), "controller.ki", "controller.integral"),
        (Start("npid_xytable", "ours.pid_ms_159", "sine_1mm"), "controller.kp", ""),
        (Start("fsmc_ballscrew", "ours.pd_dob", "sine_fast"), "controller.observer_rate", "controller.momentum"),
        (Start("grey_turning", "corrected.gpfc_b_s9", "fig6_fixed_depth"), "controller.error_scale", ""),
        (Start("vud_lathe", "corrected.vud_beta_e", "sequence"), "controller.tau", ""),
    ],
)
def test_the_integrators_whose_share_a_gain_sets_are_found_and_nothing_else_is_taken_for_one(start, key, by):
    operated = Operated(start)
    at_once = operated.restarted()
    for machine in (operated, at_once):
        machine.advance(300)
    new = {key: 0.5 * operated.sheet[key].default}
    plain, change = at_once.set(new, compare=False), operated.set(new)
    event = operated.session().events[0]
    assert (event.by, event.how) == (by, "ramped")
    unbumped = abs(plain.after - plain.before)
    assert abs(change.after - change.before) <= 0.6 * unbumped
    if by:
        rows, ghost = operated.advance(20)
        at = operated.columns.index("output")
        assert ghost is not None and np.abs(np.diff(rows[:, at] - ghost[:, at], prepend=0.0)).max() < 0.1 * unbumped


@pytest.fixture(scope="module")
def table():
    """The XY table under the forces of a spindle, its nonlinear PID with next to no integral action."""
    return Operated(Start("npid_xytable", "corrected.npid_um", "spindle_1000"))


def mean_error_um(operated, rows):
    return 1000.0 * rows[:, operated.columns.index("true_error")].mean()


@pytest.mark.slow
@pytest.mark.parametrize("kp", [1.452, 1.2, 2.0])
def test_a_gain_set_in_the_middle_of_chatter_leaves_no_lasting_error(table, kp):
    late, early = table.restarted(), table.restarted()
    before, after = round(2.72 / table.period_s), round(1.0 / table.period_s)
    early.set({"controller.kp": kp})
    for operated in (late, early):
        operated.compare("off")
        operated.advance(before)
    late.set({"controller.kp": kp})
    assert abs(mean_error_um(late, late.advance(after)[0]) - mean_error_um(early, early.advance(after)[0])) < 0.2


@pytest.mark.slow
def test_an_integral_gain_a_hundred_times_larger_makes_no_step_of_what_the_integrator_holds(table):
    operated = table.restarted()
    operated.advance(5000)
    live = operated.live
    live.state[0][live.program.plan.state.keys["controller.integral"].at] = 100.0  # hours of a standing error
    operated.advance(200)
    share = 0.000825 * live.values()["controller.integral"]
    operated.set({"controller.ki": 0.1})
    rows, ghost = operated.advance(300)
    at = operated.columns.index("output")
    assert ghost is not None and share == pytest.approx(0.0825, rel=0.01)
    unbumped = (0.1 / 0.000825 - 1.0) * share
    assert np.abs(np.diff(rows[:, at] - ghost[:, at], prepend=0.0)).max() < 1e-4 * unbumped
    assert 0.1 * live.values()["controller.integral"] == pytest.approx(share, rel=0.01)


@pytest.mark.slow
def test_a_ramp_of_the_fuzzy_controller_moves_the_output_a_twentieth_at_a_time():
    operated = Operated(Start("vud_lathe", "corrected.vud_beta_e", "fig11b_step_m170"))
    operated.advance(60)
    change = operated.set({"controller.output_gain": 1.0})
    rows, ghost = operated.advance(100)
    at = operated.columns.index("output")
    assert change.how == "ramped" and ghost is not None
    unbumped = abs(1.0 / 1.5 - 1.0) * abs(ghost[0, at])  # the output is proportional to its gain
    steps = np.abs(np.diff(np.concatenate([[ghost[0, at]], rows[:, at]])) - np.diff([ghost[0, at], *ghost[:, at]]))
    assert unbumped > 0.05 and steps.max() < 0.1 * unbumped
