"""What a step may use, and what is refused by file, line and construct."""

import math
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.kernel import ieee
from leadscrew.kernel.block import make
from leadscrew.kernel.fuse import Fuser, single_exit
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.module import Module
from leadscrew.kernel.source import tree_of
from leadscrew.util.errors import BlockError, SubsetError
from tests.kernel import zoo

OUTSIDE = {"a": 1}
FROZEN = 2.5
TABLE = np.array([1.0, 2.0, 4.0])
COUNTS = np.array([3, 1, 2])


class P(NamedTuple):
    a: float = 1.0
    n: int = 3


class S(NamedTuple):
    x: float = 0.0
    n: int = 0
    on: bool = False


def controller_of(step, params=None, state=None):
    return Loop(reference=zoo.sine, controller=make("controller", step, params, state), plant=zoo.mass, metrics={})


def uses_try(command):
    try:
        return command
    except ValueError:
        return 0.0


def uses_list(command):
    return [command][0]


def uses_lambda(command):
    f = lambda x: x  # noqa: E731
    return f(command)


def uses_dict(command):
    return OUTSIDE["a"] * command


def uses_text(command):
    x = "a"
    return command if x == "a" else 0.0


def uses_while_else(command):
    while command > 1:
        break
    else:
        pass
    return command


def uses_zip(command):
    for i in zip(range(2), range(2)):  # noqa: B905
        command += i
    return command


def uses_gamma(command):
    return math.gamma(command)


def uses_numpy(command):
    return np.dot(command, command)


def uses_field_assignment(p, command):
    p.a = command
    return command


def uses_unknown(command):
    return command + undefined_name  # noqa: F821


def uses_matmul(command):
    return command @ command


def uses_is(command):
    return 1.0 if command is None else 0.0


def uses_slice(command):
    return TABLE[0:2][0] + command


def uses_star(command):
    return max(*(command, 1.0))


def uses_bad_keyword(command):
    return helper(command, gain=2.0)


def uses_missing(command):
    return helper_two(command)


def uses_many(command):
    return helper(command, 1.0, 2.0)


def uses_bare_return(command):
    if command > 0:
        return
    return command


def uses_round_digits(command):
    return round(command, 2)


def uses_bad_field(p, command):
    return P(a=command, b=2.0).a


def uses_missing_field(command):
    return Needs(command).b


def uses_replace_blind(command):
    return (command + 1)._replace(a=1)


def uses_three_dimensions(command):
    return TABLE[0, 0, 0] + command


def uses_walrus(command):
    return (y := command) + y


def uses_two_targets(command):
    a = b = command
    return a + b


def uses_a_name_twice(command):
    a, a = command, 2.0
    return a


def uses_method(command):
    return command.hex()


class Needs(NamedTuple):
    a: float
    b: float


def helper(x, scale=3.0):
    return x * scale


def helper_two(x, y):
    return x * y


@pytest.mark.parametrize(
    ("step", "says"),
    [
        (uses_try, "'try'"), (uses_list, "a list is outside"), (uses_lambda, "'lambda'"),
        (uses_dict, "'OUTSIDE' is a dict"), (uses_text, "constant 'a'"),
        (uses_while_else, "'else' on a loop"), (uses_zip, r"only 'for NAME in range"),
        (uses_gamma, "cannot be used in a step"), (uses_numpy, "cannot be used in a step"),
        (uses_unknown, "'undefined_name' is not defined"), (uses_matmul, "'@'"), (uses_is, "'is' and 'in'"),
        (uses_star, "'starred'|in a call"), (uses_bad_keyword, "no free parameter 'gain'"),
        (uses_missing, "misses its argument 'y'"),
        (uses_many, "takes 2 arguments, 3 given"), (uses_bare_return, "bare 'return'"),
        (uses_round_digits, r"round\(\) with 2"),
        (uses_missing_field, "field 'b' is missing"), (uses_replace_blind, "is not plain"), (uses_slice, "slices"),
        (uses_three_dimensions, "one or two dimensions"), (uses_walrus, "':='"),
        (uses_two_targets, "one target"), (uses_a_name_twice, "a name twice"),
        (uses_method, "not a function that can be compiled"),
    ],
)  # fmt: skip
def test_what_is_outside_the_subset_is_refused_by_file_line_and_construct(step, says):
    with pytest.raises(SubsetError, match=says) as caught:
        controller_of(step).run(0.01)
    text = str(caught.value)
    file, line, where, _ = text.split(":", 3)
    assert Path(file).resolve() == Path(__file__) and where == f" in '{step.__name__}'"
    start = step.__code__.co_firstlineno
    assert start <= int(line) <= start + 8


def test_fields_cannot_be_assigned_and_must_exist():
    for step, says in ((uses_field_assignment, "state is immutable"), (uses_bad_field, "no free field 'b'")):
        with pytest.raises(SubsetError, match=says):
            controller_of(step, P()).run(0.01)


def test_a_step_typed_at_the_prompt_is_refused_in_one_sentence():
    space: dict = {}
    exec("def typed(command):\n    return command\n", space)
    with pytest.raises(SubsetError, match="typed at the bare prompt"):
        controller_of(space["typed"]).run(0.01)
    with pytest.raises(SubsetError, match="a lambda cannot be compiled"):
        controller_of(lambda command: command).run(0.01)
    with pytest.raises(SubsetError, match="not a plain Python function"):
        tree_of(len)


def test_a_file_that_changed_after_its_import_is_noticed(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("def moved(command):\n    return command\n")
    space: dict = {"__name__": "mine"}
    exec(compile(file.read_text(), str(file), "exec"), space)
    file.write_text("\n\n\nX = 1\n")
    with pytest.raises(SubsetError, match="changed after it was imported"):
        controller_of(space["moved"]).run(0.01)


def rich(p, s, command, feedback, t, dt):
    """Nearly everything that is allowed."""
    e = command - feedback
    a: float = -e + abs(e) * FROZEN + TABLE[s.n % 3] + COUNTS[-1]
    if (a > 3.0 and e < 1.0) or not t > 0.5:
        a += 1.0
    elif 0.0 < a < 2.0:
        a -= math.pi
    else:
        a *= 1.5
    a /= 2
    total = 0.0
    for i in range(1, p.n):
        if i == 2:
            continue
        total += i * a
    k = 5
    while k > 0:
        k -= 2
        total += k
    b = early(e, p.n)
    c, d = pair(total, y=2.0)
    q = total**2 + total**3 - abs(total) ** 0.5 + (1.0 + abs(e)) ** -1 + abs(e) ** 0.7 + (abs(e) + 1) ** -0.5
    m = (
        math.sin(a)
        + np.cos(a)
        + math.exp(-abs(a))
        + math.atan2(a, 1 + b)
        + np.sign(e)
        + math.floor(a)
        + math.hypot(a, b)
    )
    n = int(m) + round(a) + (s.n // 2) + (s.n % 2) + (3 if e > 0 else 4) + (s.n << 1) + (s.n & 3) - (s.n ^ 1)
    x = max(-10.0, min(10.0, q + m, 9.0), float(n) * 1e-3) + c - d + (7.5 // 2.0) + (-7.5 % 2.0) + min(1, 2)
    return s._replace(x=x, n=s.n + 1, on=bool(x > 0) and True), math.tanh(x) + b + dt


def early(x, n):
    """Returns from many places."""
    if x > 0.5:
        return 1.0
    for i in range(n):
        for j in range(2):
            if i * j * x > 0.1:
                return float(i)
        if x < -0.5:
            return -1.0
    if x < -0.2:
        if x < -0.3:
            return -0.5
        x = x * 2
    return x


def pair(x, y=1.0, z=0.5):
    """Two numbers."""
    if x > y:
        return x, z
    return y * 0.1, z


def test_what_is_allowed_means_the_same_on_every_engine_and_in_plain_python():
    loop = controller_of(rich, P(), S())
    runs = [loop.run(0.2, record=("output", "controller", "command", "feedback"), engine=e) for e in ("python", "llvm")]
    for name in runs[0].signals:
        assert np.array_equal(runs[0][name], runs[1][name]), name
    s = S()
    for k in range(200):
        s, output = rich(P(), s, runs[0]["command"][k], runs[0]["feedback"][k], k * 1e-3, 1e-3)
        assert output == pytest.approx(runs[0]["output"][k], rel=1e-12, abs=1e-12), k
        assert s.n == runs[0]["controller.n"][k] and s.on == bool(runs[0]["controller.on"][k])


@pytest.mark.parametrize("x", [0.7, 0.05, -0.1, -0.25, -0.4, -0.7])
def test_one_exit_gives_what_many_gave(x):
    import ast

    node, _ = tree_of(early)
    one = single_exit(node)
    assert sum(isinstance(n, ast.Return) for n in ast.walk(one)) == 1
    space: dict = {}
    exec(compile(ast.fix_missing_locations(ast.Module([one], [])), "one", "exec"), space)
    for n in (0, 1, 3, 5):
        assert space["early"](x, n) == early(x, n)
    assert Fuser({"early": node}).functions


def test_closures_and_globals_are_frozen_when_the_loop_is_built():
    gain = 3.0

    def scaled(command):
        return gain * command + early(command, 2)

    loop = controller_of(scaled)
    first = loop.run(0.01)["output"]
    gain = 100.0
    assert np.array_equal(loop.run(0.01)["output"], first)


def test_two_functions_of_one_name_do_not_mix():
    def helper(x):
        return x + 100.0

    def both(command):
        return helper(command) + other_helper(command)

    out = controller_of(both).run(0.002)
    assert out["output"][0] == 100.0 and out["output"][1] == out["command"][1] + 100.0 + out["command"][1] * 3.0


def other_helper(x):
    helper_ = helper(x)
    return helper_


def test_ieee_division_by_hand():
    assert ieee.ieee_divide(1.0, 0.0) == math.inf and ieee.ieee_divide(-1.0, 0.0) == -math.inf
    assert ieee.ieee_divide(1.0, -0.0) == -math.inf and math.isnan(ieee.ieee_divide(0.0, 0.0))
    assert ieee.ieee_divide(1e308, 1e-308) == math.inf and ieee.ieee_divide(10**400, -3) == -math.inf
    assert ieee.ieee_floor_divide(7, 0) == 0 and ieee.ieee_modulo(7, 0) == 0
    assert ieee.ieee_floor_divide(7.0, 0.0) == math.inf and math.isnan(ieee.ieee_modulo(7.0, 0.0))
    assert math.isnan(ieee.ieee_floor_divide(math.inf, 2.0)) and ieee.ieee_modulo(-7, 3) == 2
    assert ieee.ieee_floor_divide(-7.5, 2.0) == -4.0


def floor_and_mod(p, command):
    """Remainders of every sign."""
    x = command * 10.0 - 3.0
    return (x % p.a) * 1000.0 + (x // p.a) + (p.n // (p.n - 3)) + (p.n % (p.n - 3)) + (-p.n // 2) * 0.1


@pytest.mark.parametrize("a", [0.7, -0.7, 1e300, 3.0])
def test_remainders_are_those_of_python(a):
    loop = controller_of(floor_and_mod, P(a=a))
    x, y = (loop.run(1.0, engine=e)["output"] for e in ("python", "llvm"))
    assert np.array_equal(x, y)


def test_the_generated_text_is_what_it_was():
    """A snapshot: where it differs on purpose, delete the file and run again."""
    text = Loop(reference=zoo.sine(), controller=zoo.pid, plant=zoo.mass, metrics={}).program.text
    text = re.sub(r"_\d+", "_N", text)
    file = Path(__file__).parent / "snapshots" / "pid_single.py.txt"
    if not file.exists():
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
        pytest.fail("the snapshot was not there; it is written now, look at it")
    assert text == file.read_text(encoding="utf-8")


def test_names_of_the_module_are_its_own():
    module = Module()
    assert module.callable(helper) == "helper" and module.callable(helper) == "helper"
    with pytest.raises(SubsetError, match="not linked"):
        from leadscrew.kernel.drivers import hooks

        module.function(hooks.sensor)
    with pytest.raises(SubsetError, match="cannot be used in a step"):
        module.callable(len)
    assert module.callable(math.sin) == "sin"
    with pytest.raises(NotImplementedError, match="before it was linked"):
        hooks.sensor(1, 2, 3, 4, 5, 6)


def half_set(command):
    if command > 0.5:
        y = 1.0
    return y


def loop_set(command):
    for i in range(3):
        y = command * i
    return y


def all_set(command):
    if command > 0.5:
        y = 1.0
    elif command > 0.2:
        return 0.5
    else:
        y = 0.0
    while y > 2.0:
        y -= 1.0
        if y > 5.0:
            break
    return y


def test_a_local_that_some_path_does_not_set_is_refused():
    for step in (half_set, loop_set):
        with pytest.raises(SubsetError, match="'y' may be read before it is set"):
            controller_of(step).run(0.01)
    assert controller_of(all_set).run(0.01).diverged is None


def wants_field(command):
    return command.position


def local_ring(p, s, command):
    ring = s.ring
    return s, ring[5] + command


def local_zeros(command):
    scratch = np.zeros(3)
    scratch[1] = command
    return scratch[0] + scratch[1] + scratch[-1]


class Ring(NamedTuple):
    ring: np.ndarray = np.zeros(3)


def test_what_fails_in_the_first_period_names_block_file_and_line():
    with pytest.raises(BlockError, match=r"test_subset.py:\d+: in 'wants_field', in the first period: AttributeError"):
        controller_of(wants_field).run(0.01)
    with pytest.raises(BlockError, match=r"it was given command as a number"):
        controller_of(wants_field).run(0.01)


@pytest.mark.parametrize("engine", ["llvm", "python"])
def test_a_constant_index_into_a_local_array_is_guarded_too(engine):
    with pytest.warns(UserWarning, match="diverged"):
        lost = controller_of(local_ring, P(), Ring()).run(0.01, engine=engine)
    assert lost.diverged is not None and lost.diverged.period == 0
    run = controller_of(local_zeros).run(0.01, engine=engine)
    assert np.array_equal(run["output"], run["command"])


class Point(NamedTuple):
    x: float = 0.0
    y: float = 0.0


class Line(NamedTuple):
    start: Point = Point()
    end: Point = Point()


def either_end(command, feedback):
    line = Line(Point(command, 1.0), Point(feedback, 2.0))
    flipped = Line(line.end, line.start)
    chosen = line if command > feedback else flipped
    return (chosen.start if command > 0.2 else chosen.end).x + (line if feedback < 0.1 else flipped).end.y


def test_a_namedtuple_can_be_chosen_whole_and_read_field_by_field():
    runs = [controller_of(either_end).run(0.3, engine=e) for e in ("python", "llvm")]
    assert np.array_equal(runs[0]["output"], runs[1]["output"])
    for k in range(300):
        assert runs[0]["output"][k] == either_end(runs[0]["command"][k], runs[0]["feedback"][k])


FIELD = "gain"


def test_a_field_can_be_read_by_a_name_that_is_constant_and_by_no_other():
    class Gains(NamedTuple):
        gain: float = 3.0

    def named(p, command, feedback):
        return getattr(p, FIELD) * (command - feedback)

    def computed(p, command, feedback):
        name = command
        return getattr(p, name)

    parts = {"reference": zoo.sine, "plant": zoo.mass, "metrics": {}}
    loop = Loop(controller=make("controller", named, Gains()), **parts)
    fast, plain = (loop.run(0.01, engine=e)["output"] for e in ("llvm", "python"))
    assert np.array_equal(fast, plain) and np.ptp(fast) > 0.0
    module = Loop(controller=make("controller", named, Gains()), **parts).module
    with pytest.raises(SubsetError, match="no constant text"):
        module.callable(computed)
