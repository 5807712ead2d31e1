"""A loop on the compiled program of another: the same bits, and never where the steps differ."""

import numpy as np

from leadscrew.controllers.pid import pid
from leadscrew.kernel.block import controller
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.metrics import rms_error
from leadscrew.plants.mass_lugre import mass_lugre
from leadscrew.references.sine import sine
from leadscrew.references.step import step


def axis(**changes):
    parts = {
        "reference": sine(), "controller": pid(kp=50.0, kd=1.0), "plant": mass_lugre, "period": 1e-3,
        "metrics": {"rms": rms_error}, "method": "rodas",
    }  # fmt: skip
    return Loop(**(parts | changes))


def run_of(loop):
    run = loop.run(0.2)
    return np.column_stack([run["actual"], run["output"]])


def test_other_values_starts_and_periods_run_on_the_same_program_with_their_own_bits():
    first = axis()
    run_of(first)
    for changes in (
        {"controller": pid(kp=80.0)},
        {"plant": mass_lugre.starting(speed=0.1)},
        {"period": 5e-4},
        {"metrics": {"rms": rms_error(from_time=0.1)}},
        {"seed": 3},
    ):
        alone, shared = axis(**changes), axis(**changes)
        assert shared.shares(first) and shared.program is first.program
        assert np.array_equal(run_of(alone), run_of(shared))
        assert not np.array_equal(run_of(alone)[:100], run_of(first)[:100]) or "metrics" in changes or "seed" in changes


@controller()
def other(command, feedback):
    """Another law."""
    return 20.0 * (command - feedback)


def test_what_is_compiled_differently_is_not_shared():
    first = axis()
    changed = (
        {"controller": other},
        {"reference": step()},
        {"rtol": 1e-8},
        {"method": "sdirk3"},
        {"computation_delay": 1e-3},
        {"transport_delay": 1e-3},
        {"metrics": {}},
    )
    for changes in changed:
        loop = axis(**changes)
        assert not loop.shares(first)
        assert "program" not in loop.__dict__ and "signals" not in loop.__dict__
