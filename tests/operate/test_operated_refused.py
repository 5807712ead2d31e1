"""What a machine run by hand refuses, a machine that is lost, and one that is made safe."""

import pytest

from leadscrew.operate.operated import Operated, Start
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.operate.bench_study import NAME


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"controller.kp": float("nan")}, "not a number"),
        ({"controller.kp": 1e400}, "expected a finite number, at the start"),
        ({"controller.kp": "7"}, "expected a number"),
        ({"controller.kp": -1.0}, r"controller.kp = -1.0: allowed range is \[0, "),
        ({"controller.kp": True}, "expected a number"),
        ({"controller.kq": 1.0}, "did you mean controller.kp"),
        ({"scenario.amplitude_mm": 2.0}, "takes effect at the next start"),
        ({"seed": 4}, "takes effect at the next start"),
        ({"metrics.rms_error.x": 1.0}, "no parameter"),
        ({}, "nothing to set"),
    ],
)
def test_what_is_refused_changes_nothing(machine, changes, said):
    operated, plain = machine(), machine()
    operated.advance(30)
    for also in ({}, {"plant.gain": 25.0}) if changes else ({},):
        with pytest.raises((ValueRefused, NameUnknown), match=said):
            operated.set({**also, **changes})
    operated.advance(30)
    plain.advance(60)
    assert operated.digest == plain.digest and not operated.session().events and operated.ghost is None


def test_a_parameter_that_changes_the_size_of_the_loop_waits_for_the_next_start(machine):
    operated = machine("mean")
    assert operated.fixed["controller.taps"].startswith("changes the size of the loop")
    assert "controller.taps" not in operated.sheet and operated.at_start["controller.taps"].default == 4
    with pytest.raises(ValueRefused, match=r"controller\.taps cannot change in the run: it changes the size"):
        operated.set({"controller.taps": 5})
    assert Operated(Start(NAME, "mean", "way", {"controller.taps": 5})).values()["controller.taps"] == 5


def test_a_lost_loop_refuses_everything_but_a_new_start(machine):
    operated = machine("gain")
    operated.advance(100)
    operated.set({"plant.gain": -1e6})
    rows, _ = operated.advance(5000)
    assert operated.diverged and len(rows) == operated.period - 100 < 5000
    assert operated.advance(10)[0].shape == (0, len(operated.columns))
    for act in (
        lambda: operated.set({"controller.kp": 1.0}),
        lambda: operated.disturb("load_pulse"),
        lambda: operated.switch("pid"),
        operated.undo,
        lambda: operated.safe("time-out"),
    ):
        with pytest.raises(ValueRefused, match=r"the loop is lost \(diverged at .*only a reset is possible"):
            act()
    again = operated.session().run()
    assert again.identical and again.operated.diverged == operated.diverged
    fresh = operated.restarted()
    fresh.advance(100)
    assert not fresh.diverged and fresh.values()["plant.gain"] == 20.0


def test_a_safe_machine_has_the_controller_and_the_command_of_its_start(machine):
    operated = machine()
    operated.advance(50)
    operated.set({"controller.kp": 8.0, "reference.amplitude": 3.0, "plant.gain": 25.0})
    operated.switch("gain")
    operated.set({"controller.kp": 1.0})
    operated.advance(50)
    operated.safe("time-out")
    assert operated.controller == "pid" and operated.changed() == {"plant.gain": 25.0}
    assert {e.why for e in operated.session().events} == {"", "time-out"}
    assert operated.safe("time-out").new == {}
