"""One meaning: what a step gives on every engine is what the same function gives when Python calls it."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from leadscrew.kernel.block import make
from leadscrew.kernel.loop import Loop
from leadscrew.util.errors import SubsetError
from tests.kernel import zoo

TABLE = np.array([1.0, 2.0, 4.0])
COUNTS = np.array([3, 1, 2])
MATRIX = np.array([[1.0, 2.0], [3.0, 4.0]])
STEP = -1


class P(NamedTuple):
    n: int = 3
    d: int = -1


class S(NamedTuple):
    x: float = 1.0
    y: float = 2.0
    n: int = 0


class T(NamedTuple):
    a: S
    b: S
    z: float


class Ring(NamedTuple):
    ring: np.ndarray = np.zeros(3)


def both_chosen(p, s, command):
    a = S(1.0, command, 1)
    b = S(command, 2.0, 2)
    t = a if command > 0.5 else b
    u = S(1.0, 2.0, 3) if command > 0.25 else S(command, 0.0, 1)
    return t, t.x - t.y + t.n + u.x * u.y


def fields_swapped(p, s, command):
    t = S(s.x + command, s.y, s.n)
    t = S(t.y, t.x, t.n + 1)
    u = t._replace(x=t.y, y=t.x)
    return t, t.x - t.y + 100.0 * u.x


def nested(p, s, command):
    t = T(s, S(command, 1.0, 2), 3.0)
    t = T(t.b, t.a, t.z + 1.0)
    w = t.a
    t = t._replace(a=t.b, b=S(1.0, t.a.y, 3))
    return w, t.b.x + w.x + t.a.y * 10.0


def given_back(s, command):
    if command > 0.5:
        return S(s.x, command, s.n)
    return s


def state_from_a_call(p, s, command):
    t = given_back(command=command, s=s)
    return T(t, s, 0.0).a, t.x + t.y


def argument_set_anew(p, s, command):
    s = S(s.y, s.x, s.n)
    command = command * 2.0
    return s, s.x + command


def numbers_swapped(p, s, command):
    a, b = s.x, command
    a, b = b, a
    return s, a - 2 * b


def found_in_while(x, n):
    i = 0
    while i < n:
        j = 0
        while j < n:
            if i * j > x:
                return 1.0 * i + 0.1 * j
            j += 1
        i += 1
    return -1.0


def early_exits(p, s, command):
    for i in range(3):
        if command > 0.5:
            for j in range(3):
                if j * command > 1.0:
                    return s, 10.0 * i + j + found_in_while(2.0 * command, 4)
        else:
            continue
    return s, found_in_while(3.0 * command, 4)


def declared(p, s, command):
    """A comment."""
    x: float
    x: int = 3
    if command > 0.5:
        pass
    else:
        pass
    for _ in range(2):
        pass
    while False:
        pass
    return s, x + command


def powers(p, s, command):
    q = 2**3 + 2**-1 + command**0 + p.n**2 + command**1 + (1.0 + command) ** -0.5
    return s, q


def compared(p, s, command):
    b = command > 0.5
    chain = 1.0 * (0 < p.n < 5 <= 5.0 != command) + (3 > command > 0)
    return s, chain + (not command) - b + abs(b) + (b == 1) + (b & 1) + (b | 2) + (b + b) + ~p.n * 1.0


def whole_numbers(p, s, command):
    k = p.n
    k <<= 1
    k |= 1
    k &= 6
    k ^= 3
    k >>= 1
    k //= 2
    k **= 2
    k %= 5
    n = (p.n / 2) + (-p.n // 2) + (-p.n % 2) + (p.n // -2) + (p.n % -2) + abs(-p.n)
    return S(command, 2, int(command * 10)), k + n + round(2.5) + round(command * 3.3) + int(-2.7) + int(True)


def widened(p, s, command):
    k = 0
    for _ in range(3):
        k = k + 1
    if command > 0.7:
        k = k * 0.5
    return s, k // 2 + k % 2 + k / 2 + min(p.n, 2) / 4 + max(True, command) + min(1, 2.5, command)


def local_arrays(p, s, command):
    a = np.zeros((2, 3))
    a[1, 2] = command
    a[0, 2] = 2.0
    b = np.zeros(2)
    b[p.n - 3] += command
    b[p.n - 2] += 1
    return s, a[1, 2] + 10.0 * a[0, 2] + a[-1, -3] + b[0] + b[1] + COUNTS[p.n - 1] / 4 + MATRIX[1, p.n - 2]


def numpy_names(p, s, command):
    x = np.float64(3) + np.maximum(command, 0.5) + np.abs(command - 1) + math.fabs(-2) + np.isfinite(command)
    return s, x + np.sqrt(4) + math.pi + len(COUNTS)


def ranges_down(p, s, command):
    t = 0
    for i in range(p.n, -p.n, -2):
        t = t * 3 + i
        i += 10
    for i in range(-2, 2):
        t += i * i
    return s, t * command


def by_python(step, state, commands):
    out = []
    for command in commands.tolist():
        state, signal = step(P(), state, command)
        out.append(float(signal))
    return np.array(out)


def on_engine(step, engine, state=None):
    loop = Loop(
        reference=zoo.sine(frequency=20.0), controller=make("controller", step, P(), state or S()),
        plant=zoo.mass(gain=0.0), metrics={}, engine=engine,
    )  # fmt: skip
    run = loop.run(0.05)
    assert run.diverged is None
    return run


STEPS = [
    both_chosen, fields_swapped, nested, state_from_a_call, argument_set_anew, numbers_swapped, early_exits, declared,
    powers, compared, whole_numbers, widened, local_arrays, numpy_names, ranges_down,
]  # fmt: skip


@pytest.mark.parametrize("engine", ["python", "llvm"])
@pytest.mark.parametrize("step", STEPS, ids=lambda f: f.__name__)
def test_a_step_gives_in_a_loop_what_it_gives_when_called(step, engine):
    run = on_engine(step, engine)
    want = by_python(step, S(), run["command"])
    assert len(np.unique(run["command"])) > 20
    np.testing.assert_allclose(run["output"], want, rtol=1e-13, atol=1e-13)


# ---- what must not differ between engines
def last_element_set(p, s, command):
    a = np.zeros(3)
    a[-1] = command
    return s, a[0] + 10.0 * a[2]


def value_of_and(p, s, command):
    return s, (command and 2.0) + ((command - command) or 3.0)


def poke(ring, v):
    ring[0] = v
    return 1.0


def write_behind_if(p, s, command):
    v = poke(s.ring, 7.0) if command > 100.0 else 0.0
    return s, s.ring[0] + v


def write_behind_and(p, s, command):
    v = 0.0
    if command > 100.0 and poke(s.ring, 7.0) > 0.0:
        v = 1.0
    return s, s.ring[0] + v


def down_by_parameter(p, s, command):
    t = 0.0
    for i in range(3, 0, p.d):
        t += i
    return s, t


def down_by_global(p, s, command):
    t = 0.0
    for i in range(3, 0, STEP):
        t += i
    return s, t


def down_by_local(p, s, command):
    d = -1
    t = 0.0
    for i in range(3, 0, d):
        t += i
    return s, t


def up_by_minus(p, s, command):
    t = 0.0
    for i in range(0, 3, -p.d):
        t += i
    return s, t


def last_by_global(p, s, command):
    return s, TABLE[STEP] + command


def whole_or_half(p, s, command):
    x = 7
    if command > 100.0:
        x = 2.5
    return s, 1.0 if x // (p.n - 3) == 0 else 0.0


def large_literal(p, s, command):
    return s, command + 100000000000000000000


def last_row(p, s, command):
    return s, MATRIX[-1, 0] + command


def size_of_a_table(p, s, command):
    return s, TABLE.shape[0] + command


ONE_MEANING = [
    value_of_and, write_behind_if, write_behind_and, down_by_parameter, down_by_global, down_by_local, up_by_minus,
    last_by_global, whole_or_half, large_literal, last_row, size_of_a_table,
]  # fmt: skip


def test_a_constant_index_from_the_end_is_written_where_python_writes_it():
    for engine in ("python", "llvm"):
        run = on_engine(last_element_set, engine)
        np.testing.assert_array_equal(run["output"], by_python(last_element_set, S(), run["command"]))


@pytest.mark.parametrize("step", ONE_MEANING, ids=lambda f: f.__name__)
def test_a_step_means_the_same_everywhere_or_is_refused_everywhere(step):
    got = []
    for engine in ("python", "llvm"):
        try:
            got.append(on_engine(step, engine, Ring() if "write" in step.__name__ else S())["output"])
        except SubsetError as error:
            assert Path(__file__).name in str(error)
            got.append(None)
    assert (got[0] is None) == (got[1] is None), got
    if got[0] is not None:
        np.testing.assert_array_equal(got[0], got[1])


def size_is_a_parameter(p, s, command):
    a = np.zeros(p.n)
    a[0] = command
    return s, a[0]


def factorial(n):
    return 1.0 if n <= 1 else n * factorial(n - 1)


def recursive(p, s, command):
    return s, factorial(p.n) + command


@pytest.mark.parametrize("step", [size_is_a_parameter, recursive], ids=lambda f: f.__name__)
def test_what_only_the_python_engine_could_run_is_refused_by_file_and_line_on_every_engine(step):
    for engine in ("python", "llvm"):
        with pytest.raises(SubsetError, match=r"test_agreement\.py:\d+"):
            on_engine(step, engine)
