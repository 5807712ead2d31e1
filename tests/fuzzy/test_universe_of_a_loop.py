"""A fuzzy controller whose universe is too small for its loop, with periods counted by hand."""

import warnings
from typing import NamedTuple

import pytest

from leadscrew import Loop, fuzzy, plant
from leadscrew.fuzzy import Input, Output, block, triangles
from leadscrew.fuzzy.build import constants
from leadscrew.references._step import step

PERIOD = 0.01
THREE = "N Z P"
LINE = fuzzy.takagi_sugeno(
    "line",
    Input("e", -1.0, 1.0, triangles(THREE, -1.0, 1.0)),
    Output("u", -1.0, 1.0, constants({"N": -1.0, "Z": 0.0, "P": 1.0})),
    "if e is N then u is N\nif e is Z then u is Z\nif e is P then u is P",
)
"""Gives e inside of its universe, and -1 or 1 outside."""


class Place(NamedTuple):
    x: float = 0.0


@plant(None, Place(), unit="mm", output="x")
def integrator(s, u, dt):
    return Place(s.x + dt * u)


@pytest.fixture(scope="module")
def loop():
    control = block.controller(LINE, output_scale=100.0)
    return Loop(reference=step(target=50.0), controller=control, plant=integrator, period=PERIOD, engine="python")


def notes_of(loop, seconds, **changes):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return loop.using({f"controller.{k}": v for k, v in changes.items()}).run(seconds).notes


def test_an_error_beyond_the_universe_names_the_scale_and_one_that_fits(loop):
    """The axis goes 1 mm a period, so that the error is above 1 in 49 periods of 98."""
    (note,) = notes_of(loop, 98 * PERIOD)
    assert note.kind == "outside_range"
    assert "input e of the fuzzy system covers -1 to 1; error reached 50" in note.message
    assert "controller.scale_e=1 puts it outside in 50 % of the periods" in note.message
    assert note.message.endswith("controller.scale_e=0.02 fits it in.")


def test_a_universe_that_just_holds_the_error_gives_no_note(loop):
    assert notes_of(loop, 0.5, scale_e=0.02) == ()


def test_of_a_loop_that_runs_away_only_the_error_at_rest_counts(loop):
    kinds = [n.kind for n in notes_of(loop, 1.0, scale_e=0.02, scale_output=-100.0)]
    assert kinds == ["moved_away"]
    away, outside = notes_of(loop, 1.0, scale_output=-100.0)
    assert away.kind == "moved_away" and outside.message.endswith("controller.scale_e=0.02 fits it in.")


def test_the_change_of_the_error_is_judged_in_its_own_universe():
    """Where the axis goes 1 mm a period, a scale of 3 puts the change at -3; in the first period there is none."""
    de = Input("de", -1.0, 1.0, triangles(THREE, -1.0, 1.0))
    both = fuzzy.takagi_sugeno(
        "both", [LINE.inputs[0], de], LINE.outputs[0],
        "if e is N then u is N\nif e is Z then u is Z\nif e is P then u is P\nif de is N and e is N then u is N",
    )  # fmt: skip
    control = block.controller(both, {"e": ("error", 0.02), "de": ("change", 3.0)}, output_scale=100.0)
    made = Loop(reference=step(target=50.0), controller=control, plant=integrator, period=PERIOD, engine="python")
    (note,) = notes_of(made, 0.02 + PERIOD)
    assert "input de" in note.message and "puts it outside in 66.7 % of the periods" in note.message
    assert note.message.endswith("controller.scale_de=1 fits it in.")
