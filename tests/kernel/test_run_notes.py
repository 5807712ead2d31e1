"""What a run says of a loop that moves away from its target, with numbers worked by hand."""

import warnings
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import Loop, controller, disturbance, plant, reference
from leadscrew.kernel.loop import RunWarning
from leadscrew.references._s_curve import s_curve
from leadscrew.references._step import step

PERIOD = 0.01


class Gain(NamedTuple):
    k: float = 10.0


class Place(NamedTuple):
    x: float = 0.0


class Two(NamedTuple):
    x: float = 0.0
    lag: float = 0.0


@controller(Gain())
def proportional(p, command, feedback):
    return p.k * (command - feedback)


@controller(Gain())
def of_position(p, command, feedback):
    return p.k * (command.position - feedback)


@plant(None, Place(), unit="mm", output="x")
def integrator(s, u, load, dt):
    return Place(s.x + dt * (u + load))


@plant(None, Place(), unit="mm", output="x", sense=-1)
def mirrored(s, u, dt):
    return Place(s.x - dt * u)


def undershoot(s):
    return s.x - 2.0 * s.lag


@plant(None, Two(), unit="mm", output=undershoot)
def first_the_wrong_way(s, u, dt):
    return Two(s.x + dt * u, s.lag + dt / 0.05 * (u * 0.05 - s.lag))


@disturbance()
def heavy(t):
    return -500.0


@reference()
def nowhere(t):
    return 0.0


def run_of(seconds=0.2, record=None, **parts):
    parts = {"reference": step(target=5.0), "controller": proportional, "plant": integrator} | parts
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return Loop(**parts, period=PERIOD, engine="python").run(seconds, record)


def kinds(run):
    return [n.kind for n in run.notes]


def test_a_reversed_gain_is_named_with_its_errors():
    """|e| = 5 (1 + k dt)^n: 19 periods of 10 % after the first sample."""
    run = run_of(controller=proportional(k=-10.0))
    (note,) = run.notes
    assert note.kind == "moved_away"
    assert f"{5.0 * 1.1**19:.4g} mm at the end" in note.message and "at most 5 mm at rest" in note.message
    assert "sign of the controller or of the drive reversed?" in note.message


def test_a_reversed_drive_is_named_in_a_warning():
    loop = Loop(reference=step(target=-5.0), controller=proportional, plant=mirrored, period=PERIOD, engine="python")
    with pytest.warns(RunWarning, match=r"positive input moves mirrored towards negative values"):
        run = loop.run(0.2)
    assert run.manifest["notes"][0]["kind"] == "moved_away"
    assert "reversed" in run._repr_html_()


def test_a_move_that_starts_without_an_error_runs_away_too():
    run = run_of(0.6, reference=s_curve(distance=5.0), controller=of_position(k=-10.0))
    assert kinds(run) == ["moved_away"]
    assert run_of(0.6, reference=s_curve(distance=5.0), controller=of_position(k=10.0)).notes == ()


def test_a_loop_that_starts_away_from_a_target_of_zero_is_judged():
    assert kinds(run_of(reference=nowhere, plant=integrator.starting(x=3.0), controller=proportional(k=-10.0))) == [
        "moved_away"
    ]


@pytest.mark.parametrize(
    "parts",
    [
        {},
        {"controller": proportional(k=0.0)},
        {"controller": proportional(k=250.0), "seconds": 0.5},
        {"plant": first_the_wrong_way, "controller": proportional(k=2.0), "seconds": 2.0},
        {"plant": first_the_wrong_way, "controller": proportional(k=100.0), "seconds": 0.3},
        {"disturbance": heavy},
        {"reference": nowhere, "disturbance": heavy},
        {"reference": nowhere},
    ],
    ids=[
        "follows",
        "rests",
        "gain too high",
        "undershoot",
        "undershoot, unstable",
        "weak under a load",
        "only a load",
        "nothing to do",
    ],
)
def test_no_loop_is_called_reversed_that_is_not(parts):
    run = run_of(**parts)
    assert run.notes == ()
    if parts.get("controller") is not None and parts["controller"].params.k == 250.0:
        assert abs(run["true_error"][-1]) > 1e6  # it grows by 1.5 a period, from side to side


def test_a_run_without_the_signals_is_not_judged():
    assert run_of(controller=proportional(k=-10.0), record=["output"]).notes == ()


def test_a_reversed_loop_that_diverges_says_so_too():
    run = run_of(8.0, controller=proportional(k=-10_000.0))
    assert run.diverged is not None and kinds(run) == ["moved_away"]
    assert np.all(np.diff(np.abs(run["true_error"])) > 0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("study", "names"),
    [
        ("vud_lathe", ["corrected.vud_beta_one", "ours.original_p"]),
        ("sofnn_tangent", ["ours.pid"]),
        ("grey_turning", [None]),
        ("npid_xytable", [None]),
    ],
)
def test_no_scenario_of_a_study_is_called_reversed(study, names):
    """Controllers that limit-cycle and creep among them."""
    from leadscrew import resolve

    of = resolve.study(study)
    for name in names:
        for scenario in list(of.scenarios.values())[::4]:
            loop = of.loop(name or next(iter(of.controllers)), scenario.name)
            assert loop.run(min(scenario.duration_s, 5.0)).notes == (), (name, scenario.name)
