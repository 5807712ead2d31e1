"""A fuzzy system in a loop: the same bits on every engine, its numbers tunable, and as a function inside a step."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew import Loop, controller, plant, reference
from leadscrew.fuzzy import block
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.references._s_curve import s_curve
from leadscrew.references._step import step
from leadscrew.references._trapezoid import trapezoid
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.budget import in_every_run
from tests.fuzzy.systems import mamdani, sugeno, with_output
from tests.tools import runnable


class Moving(NamedTuple):
    x: float = 0.0
    v: float = 0.0


@plant(None, Moving())
def cart(s, u):
    return Moving(s.v, u - 2.0 * s.v)


def loop(made) -> Loop:
    return Loop(reference=step(target=0.8), controller=made, plant=cart, period=0.01)


SYSTEMS = {
    "sum": mamdani(),
    "exact": mamdani(integration="exact"),
    "table": sugeno(),
    "held": sugeno(lock_previous=True, default=0.0),
    "bisector": mamdani(defuzzifier="bisector"),
}


@pytest.mark.parametrize("engine", ["python", "c"])
@pytest.mark.parametrize("name", in_every_run(SYSTEMS, ("exact", "held")))
def test_a_loop_gives_the_same_bits_on_every_engine(name, engine):
    made = loop(block.controller(SYSTEMS[name], {"e": ("error", 0.9), "de": ("change", 20.0)}, output_scale=30.0))
    run, other = made.run(0.5), made.run(0.5, engine=runnable(engine))
    assert np.array_equal(run["output"], other["output"])
    assert np.ptp(run["output"]) > 1.0
    assert abs(run["actual"][-1] - 0.8) < 0.3


def test_the_block_is_the_system_at_error_and_change():
    made = block.controller(mamdani(), {"e": ("error", 0.9), "de": ("change", 20.0)}, output_scale=30.0)
    run = loop(made).run(0.3)
    error = run["command"] - run["actual"]
    change = np.diff(error, prepend=error[0])
    expected = 30.0 * compiled(mamdani()).many(e=0.9 * error, de=20.0 * change)
    np.testing.assert_array_equal(run["output"], expected)


def test_an_incremental_controller_adds_up():
    plain = {"e": ("error", 0.5), "de": ("rate", 0.05)}
    made = block.controller(sugeno(), plain, output_scale=0.1, incremental=True)
    run = loop(made).run(0.3)
    error = run["command"] - run["actual"]
    parts = 0.1 * compiled(sugeno()).many(e=0.5 * error, de=0.05 * (np.diff(error, prepend=error[0]) / 0.01))
    np.testing.assert_array_equal(run["output"], np.cumsum(parts))


@pytest.mark.parametrize("engine", in_every_run(["llvm", "python", "c"], ["llvm"]))
@pytest.mark.parametrize(
    "made", [s_curve(distance=0.8, max_velocity=2.0), trapezoid(distance=0.8, max_acceleration=20.0)]
)
def test_of_a_motion_the_position_counts(made, engine):
    """The same bits as with a reference that commands the position alone."""

    @reference(made.params, prepare=made.prepare)
    def position(p, t):
        motion = made(p, t)
        return motion.position

    inputs = {"e": ("error", 0.9), "de": ("change", 20.0)}
    follower = block.controller(mamdani(), inputs, output_scale=30.0, command="position")
    moving = Loop(reference=made, controller=follower, plant=cart, period=0.01)
    plain = Loop(
        reference=position, controller=block.controller(mamdani(), inputs, output_scale=30.0), plant=cart, period=0.01
    ).run(0.5)
    run = moving.run(0.5, engine=runnable(engine))
    np.testing.assert_array_equal(run["output"], plain["output"])
    np.testing.assert_array_equal(run["error"], plain["error"])
    assert np.ptp(plain["output"]) > 1.0


def test_a_reading_of_several_fields_and_the_command_itself_are_taken_by_field():
    def whole(s):
        return s

    @plant(None, Moving(), output=whole)
    def seen(s, u):
        return Moving(s.v, u - 2.0 * s.v)

    made = block.controller(sugeno(), {"e": "command", "de": "feedback"}, command="position", feedback="x")
    run = Loop(reference=s_curve(distance=0.8), controller=made, plant=seen, period=0.01).run(0.3)
    expected = compiled(sugeno()).many(e=run["command.position"], de=run["feedback.x"])
    np.testing.assert_array_equal(run["output"], expected)


@pytest.mark.parametrize("field", ["1", "a.", "a b", "lambda", "p)+(q"])
def test_what_cannot_be_a_field_is_refused(field):
    with pytest.raises(ValueRefused, match=r"expected the name of a field, such as 'position'"):
        block.controller(mamdani(), command=field)


def test_scales_and_numbers_of_the_system_are_parameters():
    made = block.controller(sugeno(lock_range=False), {"e": "error", "de": "change"})
    tables = made.params.tables
    doubled = np.array(tables.terms)
    doubled[14:, 0] *= 2.0
    tuned = made(**{"tables.terms": doubled}, scale_output=0.5)
    np.testing.assert_allclose(loop(tuned).run(0.2)["output"], loop(made).run(0.2)["output"], rtol=1e-14)


def test_numbers_that_would_change_the_structure_are_refused():
    made = block.controller(sugeno())
    weights = np.array(made.params.tables.weights)
    weights[3] = 0.5
    with pytest.raises(ValueRefused, match="make a new block of the changed system"):
        loop(made(**{"tables.weights": weights})).run(0.1)


def test_a_system_is_called_inside_a_step():
    infer = block.function(mamdani())
    two = block.function(sugeno())

    class Gains(NamedTuple):
        k: float = 20.0

    @controller(Gains())
    def mixed(p, command, feedback):
        error = command - feedback
        return p.k * (infer(error, 0.1) + 0.5 * two(error, -0.2))

    run = loop(mixed).run(0.2)
    assert np.array_equal(run["output"], loop(mixed).run(0.2, engine="python")["output"])
    error = run["command"] - run["actual"]
    a, b = compiled(mamdani()).many(e=error, de=0.1), compiled(sugeno()).many(e=error, de=-0.2)
    np.testing.assert_array_equal(run["output"], 20.0 * (a + 0.5 * b))


def test_what_does_not_fit_is_refused():
    with pytest.raises(NameUnknown, match="no input 'x'"):
        block.controller(mamdani(), {"x": "error"})
    with pytest.raises(NameUnknown, match="no signal 'eror'; did you mean error"):
        block.controller(mamdani(), {"e": "eror", "de": "change"})
    with pytest.raises(ValueRefused, match="nothing is said about the input de"):
        block.controller(mamdani(), {"e": "error"})
    with pytest.raises(NameUnknown, match="no output 'v'"):
        block.controller(mamdani(), output="v")
    three = replace(mamdani(), inputs=(*mamdani().inputs, replace(mamdani().inputs[0], name="third")))
    with pytest.raises(ValueRefused, match="has 3 inputs"):
        block.controller(three)


def test_a_loop_of_a_tuned_copy_shares_its_machine_code():
    made = block.controller(with_output(mamdani(), default=0.0))
    a, b = loop(made), loop(made(scale_e=2.0))
    assert a.program.name == b.program.name
