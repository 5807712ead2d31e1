"""What data sheets, sources and stiff plants say when something is not right."""

import math
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from leadscrew.kernel import parameters
from leadscrew.kernel.block import make
from leadscrew.kernel.loop import DivergenceWarning, Loop
from leadscrew.kernel.parameters import Doc, Ge, Gt, Le, Lt, Unit
from leadscrew.util.errors import BlockError, NameUnknown, SubsetError, ValueRefused
from tests.kernel import zoo


class Sheet(NamedTuple):
    gain: Annotated[float, Unit("V"), Gt(0), Lt(10), Doc("Gain.")] = 1.0
    share: Annotated[float, Ge(0), Le(1)] = 0.5
    low: Annotated[float, Le(5)] = 0.0
    count: Annotated[int, Ge(0)] = 3
    on: bool = True
    weights: Annotated[np.ndarray, Ge(0), Le(9)] = np.array([1.0, 2.0])
    plain = 0


class Blind(NamedTuple):
    a: "NoSuchType" = 1.0  # type: ignore[name-defined]  # noqa: F821


SHEET = {e.key: e for e in parameters.entries(Sheet())}


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("gain", 10.0, r"gain = 10.0 \(here\): allowed range is \(0, 10\) V"),
        ("gain", math.inf, r"allowed range is \(0, 10\) V"),
        ("share", -0.1, r"allowed range is \[0, 1\]"),
        ("share", True, "expected a number"),
        ("share", None, "expected a number"),
        ("share", 10**400, "a whole number of 401 digits is too large"),
        ("low", math.inf, r"allowed range is \(-inf, 5\]"),
        ("count", 2.5, "expected a whole number"),
        ("count", math.inf, "expected a whole number"),
        ("count", 2**53 + 2, r"beyond 2\^53"),
        ("on", 2, "expected true or false"),
        ("on", "yes", "expected true or false"),
        ("weights", "ab", "expected an array of numbers"),
        ("weights", [1.0], r"expected an array of shape \(2,\), got \(1,\)"),
        ("weights", [1.0, math.inf], "not finite"),
        ("weights", [1.0, 9.5], r"allowed range is \[0, 9\]"),
    ],
)
def test_a_value_is_refused_with_its_range_unit_and_place(key, value, says):
    with pytest.raises(ValueRefused, match=says) as caught:
        SHEET[key].check(value, "here")
    assert key in str(caught.value)


def test_a_value_that_fits_comes_out_in_the_type_of_its_entry():
    assert SHEET["low"].check(-math.inf) == -math.inf
    for key, value, want in (("count", 4.0, 4), ("on", 1, True), ("on", np.bool_(False), False), ("gain", 2, 2.0)):
        got = SHEET[key].check(value)
        assert got == want and type(got) is type(want)
    np.testing.assert_array_equal(SHEET["weights"].check([0, 9]), [0.0, 9.0])
    ranges = {"gain": "(0, 10)", "share": "[0, 1]", "low": "(-inf, 5]", "count": "[0, inf)", "on": ""}
    assert {k: SHEET[k].range for k in ranges} == ranges
    assert SHEET["gain"].unit == "V" and SHEET["gain"].doc == "Gain." and SHEET["weights"].type == "array"
    blind = next(parameters.entries(Blind()))
    assert blind.type == "float" and blind.range == ""


def test_parameters_are_replaced_by_dotted_keys_and_the_nearest_names_are_named():
    pair = zoo.TwoPIDParams()
    new = parameters.checked_replace(pair, {"x.kp": 3.0, "y.ki": 0.5}, "two")
    assert (new.x.kp, new.y.ki, new.x.kd) == (3.0, 0.5, pair.x.kd) and pair.x.kp != 3.0
    with pytest.raises(NameUnknown, match=r"two has no parameter 'x.kpp'; did you mean x.kp"):
        parameters.checked_replace(pair, {"x.kpp": 3.0}, "two")
    with pytest.raises(NameUnknown, match=r"no parameter 'zzzz'; known: x\.kp"):
        parameters.checked_replace(pair, {"zzzz": 3.0}, "two")
    with pytest.raises(NameUnknown, match=r"nothing has no parameter 'a'$"):
        parameters.checked_replace(None, {"a": 1.0}, "nothing")


# ---- two-dimensional states
class Board(NamedTuple):
    cells: np.ndarray = np.zeros((2, 3))


class Where(NamedTuple):
    row: int = 1
    column: int = 2


def marked(p, s, command):
    """Writes where told and gives the sum."""
    s.cells[p.row, p.column] = s.cells[p.row, p.column] + command
    total = 0.0
    for i in range(s.cells.shape[0]):
        for j in range(s.cells.shape[1]):
            total += s.cells[i, j] * (1 + 3 * i + j)
    return s, total


@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_a_write_outside_a_board_is_divergence_and_one_inside_goes_to_its_cell(engine):
    loop = Loop(
        reference=zoo.sine(frequency=20.0), controller=make("controller", marked, Where(), Board()),
        plant=zoo.mass(gain=0.0), metrics={}, engine=engine,
    )  # fmt: skip
    run = loop.run(0.02)
    np.testing.assert_allclose(run["output"], 6.0 * np.cumsum(run["command"]), rtol=1e-12)
    for where in ({"controller.row": 2}, {"controller.column": 3}, {"controller.column": -1}):
        with pytest.warns(DivergenceWarning):
            lost = loop.using(where).run(0.02)
        assert lost.diverged is not None and lost.diverged.period == 0


# ---- more of what the subset refuses
def undefined_later(command):
    if command > 0.5:
        y: float
        z = 1.0
    else:
        y = 2.0
        z = 2.0
    return y + z


def added_to_nothing(command):
    if command > 10.0:
        y = 1.0
    y += command
    return y


def reads_after_break(command):
    while command > 0.0:
        y = 1.0
        break
    return y


def star_arguments(*command):
    return command[0]


def doubled(x):
    return 2.0 * x


def keyword_in_builtin(command):
    return max(command, default=1.0)


def of_a_class(command):
    return Board.__len__(command)


def from_a_method(command):
    return RANDOM.random() + command


def from_a_type(command):
    return complex(command)


def replaced_unknown(p, command):
    return p._replace(depth=1).row + command


def replaced_of_a_call(command):
    return Where(1, 2)._replace(row=1).row + command


def three_deep(command):
    a = np.zeros(2)
    a[0, 0, 0] = command
    return a[0]


def unpacked_into_fields(s, command):
    s.cells[0, 0], x = command, 1.0
    return s, x


def index_too_far(command):
    return WEIGHTS[3] + command


def looped_over_a_list(command):
    for i in WEIGHTS:
        command += i
    return command


RANDOM = np.random.default_rng(1)
WEIGHTS = np.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("step", "params", "state", "says"),
    [
        (undefined_later, None, None, "'y' may be read before it is set"),
        (added_to_nothing, None, None, "'y' may be read before it is set"),
        (reads_after_break, None, None, "'y' may be read before it is set"),
        (keyword_in_builtin, None, None, r"keywords in max\(\)"),
        (of_a_class, None, None, "not a plain Python function|cannot be compiled"),
        (from_a_method, None, None, "cannot be used in a step|not a plain Python function"),
        (from_a_type, None, None, r"complex\(\) with 1 argument"),
        (replaced_unknown, Where(), None, "Where has no field 'depth'; it has row, column"),
        (replaced_of_a_call, None, None, "'_replace' on a name only"),
        (three_deep, None, None, "one or two dimensions"),
        (unpacked_into_fields, None, Board(), "only names on the left of a tuple assignment"),
        (index_too_far, None, None, "the index 3 into an array of 3"),
        (looped_over_a_list, None, None, r"only 'for NAME in range\(...\)'"),
    ],
    ids=lambda x: getattr(x, "__name__", ""),
)
def test_a_step_outside_the_subset_is_refused_by_file_line_and_sentence(step, params, state, says):
    loop = Loop(reference=zoo.sine, controller=make("controller", step, params, state), plant=zoo.mass, metrics={})
    with pytest.raises(SubsetError, match=says) as caught:
        loop.run(0.01)
    file, line, _ = str(caught.value).split(":", 2)
    assert Path(file).resolve() == Path(__file__)
    assert step.__code__.co_firstlineno <= int(line) <= step.__code__.co_firstlineno + 8


def test_a_file_that_no_longer_parses_is_named(tmp_path):
    file = tmp_path / "broken.py"
    file.write_text("def step(command):\n    return command\n")
    space: dict = {"__name__": "broken"}
    exec(compile(file.read_text(), str(file), "exec"), space)
    file.write_text("def step(command:\n")
    with pytest.raises(SubsetError, match=r"broken\.py: the file does not parse any more"):
        Loop(reference=zoo.sine, controller=make("controller", space["step"]), plant=zoo.mass, metrics={}).run(0.01)


# ---- stiff plants
class StiffState(NamedTuple):
    x: float = 0.5
    y: float = 1.0


def explodes(s, u):
    """Reaches infinity after a tenth of a second: ``x' = x**2`` from 10."""
    return StiffState(s.x * s.x + 0.0 * u, -1e4 * s.y)


def crossed(s, u):
    """An oscillator whose Jacobian has nothing on its diagonal."""
    return StiffState(50.0 * s.y, -50.0 * s.x + 0.0 * u)


@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_a_plant_that_reaches_infinity_within_a_period_is_divergence_and_not_a_hang(engine):
    loop = Loop(
        reference=zoo.sine, controller=zoo.pid, plant=make("plant", explodes, None, StiffState(x=10.0)), method="rodas",
        metrics={}, engine=engine, period=0.02, rtol=1e-4, atol=1e-6,
    )  # fmt: skip
    with pytest.warns(DivergenceWarning):
        run = loop.run(1.0)
    assert run.diverged is not None and 0.08 < run.diverged.time <= 0.121
    before = run.time < 0.075
    np.testing.assert_allclose(run["actual"][before], 10.0 / (1.0 - 10.0 * run.time[before]), rtol=1e-2)


def test_an_oscillator_turns_as_the_cosine_does():
    loop = Loop(
        reference=zoo.sine, controller=zoo.pid, plant=make("plant", crossed, None, StiffState(1.0, 0.0)),
        method="rodas", metrics={}, engine="python", period=0.01, rtol=1e-8, atol=1e-10,
    )  # fmt: skip
    run = loop.run(0.2)
    np.testing.assert_allclose(run["actual"], np.cos(50.0 * run.time), atol=1e-5)


class Two(NamedTuple):
    a: np.ndarray = np.zeros(2)
    b: np.ndarray = np.ones(2)


def swaps(s, command, feedback):
    return Two(s.b, s.a), s.a[0]


def test_a_state_that_comes_back_with_other_arrays_is_refused():
    loop = Loop(reference=zoo.sine, controller=make("controller", swaps, None, Two()), plant=zoo.mass, metrics={})
    with pytest.raises(BlockError, match="another array as 'a'"):
        loop.run(0.1)
