"""Hostile steps: each gives the same bits on every engine, or is refused on all of them by file and line."""

import math
import warnings
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.kernel.block import make
from leadscrew.kernel.loop import Loop
from leadscrew.util.errors import SubsetError
from tests.kernel import zoo
from tests.kernel.hostile import SAME, P, S
from tests.kernel.hostile_refused import REFUSED
from tests.kernel.printed import same
from tests.tools import runnable

ENGINES = ["python", "llvm", "c"]


def loop_of(step, state=None):
    params = P() if "p" in step.__code__.co_varnames[: step.__code__.co_argcount] else None
    return Loop(
        reference=zoo.sine(frequency=20.0), controller=make("controller", step, params, state or S()),
        plant=zoo.mass(gain=0.0), metrics={},
    )  # fmt: skip


def outputs(step, engine):
    runnable(engine)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        live = loop_of(step).start(engine=engine)
        run = live.advance(50, record=["output", "controller.x", "controller.n", "controller.on"])
    return {name: run[name] for name in run.signals} | {"lost": np.array([run.diverged is not None])}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("step", REFUSED, ids=lambda f: f.__name__)
def test_what_engines_would_differ_in_is_refused_on_each_by_file_line_and_what_to_write(step, engine):
    loop = loop_of(step)
    for _ in range(2):  # a refusal is not forgotten
        with pytest.raises(SubsetError, match=REFUSED[step]) as caught:
            loop.run(0.05, engine=engine)
        assert "hostile_refused.py:" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("engine", ENGINES[1:])
@pytest.mark.parametrize("step", SAME, ids=lambda f: f.__name__)
def test_hostile_steps_are_the_same_bits(step, engine):
    got, want = outputs(step, engine), outputs(step, "python")
    for name, expected in want.items():
        assert same(np.asarray(got[name], float), np.asarray(expected, float)), name


# ---- by hand
def whole_parts(p, s, command):
    """Of numbers in (-1, 0): a whole number has no negative zero."""
    x = p.gain - 0.7
    return s, math.atan2(int(x), -1.0) + math.copysign(10.0, round(x)) + math.copysign(100.0, 1.0 * int(x))


def signs_of_nan(p, s, command):
    """Of 0/0, for which processors and compilers give either sign."""
    lost = (p.n - 3) / (p.n - 3)
    return s, math.copysign(1.0, lost) + math.copysign(2.0, -lost) + math.copysign(4.0, 1e308 * 10.0 * p.gain * 0.0)


def large_whole_parts(p, s, command):
    """Beyond 2^53, which is what a double holds without gaps."""
    return s, 1.0 * (int(p.gain * 2e17) - 10**17) + (int(2**60 + p.n) - 2**60)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("step", "value"), [(whole_parts, math.pi + 110.0), (signs_of_nan, 7.0), (large_whole_parts, 3.0)]
)
def test_whole_parts_and_signs_are_what_python_says(step, value, engine):
    assert (loop_of(step).run(0.05, engine=runnable(engine))["output"] == value).all()


class Count(NamedTuple):
    n: int = 2**53 - 21


def counts_up(s, command):
    return Count(s.n + 1), command


def doubles(s, command):
    return Count(s.n * 2), command


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("step", "counts"), [(counts_up, range(2**53 - 20, 2**53 + 1)), (doubles, [2**54 - 42])])
def test_a_count_that_a_state_cannot_keep_exactly_stops_the_loop_and_is_named(step, counts, engine):
    loop = loop_of(step, Count())
    with pytest.warns(UserWarning, match=r"controller.n is beyond 2\^53, up to which a state keeps whole numbers"):
        run = loop.run(0.05, record=["controller.n"], engine=runnable(engine))
    assert run["controller.n"].tolist() == list(counts)
    batch = loop.batch(0.05, {"plant.damping": [10.0, 11.0]}, engine=engine)
    assert batch.diverged_at.tolist() == [run.diverged.time] * 2


# ---- plants
class Room(NamedTuple):
    x: float = 0.5
    a: np.ndarray = np.array([1.0, 2.0])
    b: np.ndarray = np.array([3.0, 4.0])


def plant_swaps(s, u, dt):
    return Room(s.x + dt * u, s.b, s.a)


def plant_swaps_late(s, u, dt):
    if u > 0.5:
        s = Room(s.x, s.b, s.a)
    return Room(s.x + dt * (s.a[0] - u), s.a, s.b)


def plant_makes_a_new_one(s, u, dt):
    a = np.zeros(2)
    a[0] = s.x
    return Room(s.x + dt * u, a, s.b)


def rate_with_a_new_one(s, u):
    return Room(u - s.x, np.zeros(2), s.b)


def plant_writes(s, u, dt):
    s.a[0] = s.a[0] + dt * u
    s.b[1] = s.x
    return Room(s.x + dt * (u - s.a[0]), s.a, s.b)


def rate_reads(s, u):
    return Room(u - s.x * s.a[1], s.a, s.b)


def plant_loop(step, method="rk4"):
    return Loop(
        reference=zoo.sine(frequency=20.0), controller=zoo.pid(kp=0.8), plant=make("plant", step, None, Room()),
        metrics={}, method=method,
    )  # fmt: skip


@pytest.mark.parametrize("step", [plant_swaps, plant_swaps_late, plant_makes_a_new_one, rate_with_a_new_one])
def test_a_plant_that_returns_other_arrays_is_refused(step):
    for engine in ENGINES:
        with pytest.raises(SubsetError, match=r"another array as 'a'|one array on one path") as caught:
            plant_loop(step).run(0.05, engine=engine)
        assert "test_one_meaning.py:" in str(caught.value)


@pytest.mark.parametrize("engine", ENGINES[1:])
@pytest.mark.parametrize(
    ("step", "method"),
    [(plant_writes, "rk4"), (rate_reads, "rk4"), (rate_reads, "sdirk3"), (rate_reads, "rodas")],
)
def test_a_plant_that_keeps_its_arrays_runs_the_same_under_every_integrator(step, method, engine):
    got, want = (plant_loop(step, method).run(0.05, engine=e)["actual"] for e in (runnable(engine), "python"))
    assert same(got, want) and np.ptp(want) > 0
