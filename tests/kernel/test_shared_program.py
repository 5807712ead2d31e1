"""Loops that differ in values alone run on one compiled program: the same bits, and never where the steps differ."""

import numpy as np
import pytest

from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import rms_error
from leadscrew.kernel.normalised_trees import trees
from leadscrew.kernel.program import programs
from leadscrew.references._sine import sine
from leadscrew.references._step import step
from leadscrew.studies.npid_xytable.tunings import table_pid
from tests.kernel import zoo


def axis(**changes):
    parts = {
        "reference": sine(), "controller": table_pid(kp=50.0, kd=1.0), "plant": zoo.mass, "period": 1e-3,
        "metrics": {"rms": rms_error},
    }  # fmt: skip
    return Loop(**(parts | changes))


def run_of(loop):
    run = loop.run(0.2)
    return np.column_stack([run["actual"], run["output"]])


def test_other_values_starts_and_periods_run_on_the_same_program_with_their_own_bits():
    first = axis()
    run_of(first)
    for changes in (
        {"controller": table_pid(kp=80.0)},
        {"plant": zoo.mass.starting(velocity=0.1)},
        {"period": 5e-4},
        {"metrics": {"rms": rms_error(from_time=0.1)}},
        {"seed": 3},
    ):
        shared = axis(**changes)
        bits = run_of(shared)
        assert shared.program is first.program
        programs.clear()
        alone = axis(**changes)
        assert np.array_equal(run_of(alone), bits) and alone.program is not first.program
        assert not np.array_equal(bits[:100], run_of(first)[:100]) or "metrics" in changes or "seed" in changes
        programs.clear()
        first = axis()
        run_of(first)


@controller()
def other(command, feedback):
    """Another law."""
    return 20.0 * (command - feedback)


@pytest.mark.parametrize(
    "changes",
    [
        {"controller": other},
        {"reference": step()},
        {"rtol": 1e-8},
        {"method": "sdirk3"},
        {"computation_delay": 1e-3},
        {"transport_delay": 1e-3},
        {"metrics": {}},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_what_is_compiled_differently_has_a_program_of_its_own(changes):
    assert axis(**changes).program is not axis().program


def gained(error, gain=2.0):
    return gain * error


@controller()
def calls(command, feedback):
    """A law whose gain is the default of what it calls."""
    return gained(command - feedback)


def test_a_loop_linked_after_others_is_the_one_linked_alone():
    later = [{"controller": other}, {"metrics": {}}, {"computation_delay": 1e-3}, {"method": "rodas"}]
    names = []
    for forget in (False, True):
        axis()
        for changes in later:
            programs.clear()
            if forget:
                trees.clear()
            program = axis(**changes).program
            names.append((program.name, program.batches))
    assert names[: len(later)] == names[len(later) :] and len(set(names)) == len(later)


def test_a_default_of_a_called_function_changed_between_two_loops_counts_in_the_second(monkeypatch):
    before = first_output(calls)
    monkeypatch.setattr(gained, "__defaults__", (6.0,))
    assert first_output(calls) == 3.0 * before != 0.0


GAIN = 20.0
TABLE = np.array([20.0, 1.0])


@controller()
def reads_outside(command, feedback):
    """A law with a gain and a table from outside the step."""
    return GAIN * TABLE[0] * (command - feedback)


def made(gain):
    """A law with its gain in a closure that can be changed."""

    @controller()
    def law(command, feedback):
        return gain * (command - feedback)

    def change(value):
        nonlocal gain
        gain = value

    return law, change


def first_output(law):
    return axis(controller=law, reference=step()).run(0.002)["output"][0]


def test_a_global_or_a_table_changed_between_two_loops_counts_in_the_second(monkeypatch):
    before = first_output(reads_outside)
    assert first_output(reads_outside) == before != 0.0
    monkeypatch.setitem(globals(), "GAIN", 40.0)
    assert first_output(reads_outside) == 2.0 * before
    monkeypatch.setitem(globals(), "GAIN", 20.0)
    monkeypatch.setitem(globals(), "TABLE", TABLE.copy())
    assert first_output(reads_outside) == before
    TABLE[0] = 60.0
    assert first_output(reads_outside) == 3.0 * before


def test_a_closure_variable_changed_between_two_loops_counts_in_the_second():
    law, change = made(5.0)
    before = first_output(law)
    change(10.0)
    assert first_output(law) == 2.0 * before


def test_code_replaced_in_place_as_autoreload_does_counts_in_the_next_loop():
    law, _ = made(5.0)
    before = first_output(law)

    def tripled(gain):
        def law(command, feedback):
            return 3.0 * gain * (command - feedback)

        return law

    law.step.__code__ = tripled(5.0).__code__
    assert first_output(law) == 3.0 * before
