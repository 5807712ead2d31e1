"""Steps that a printer of C may stumble over: their names, their comments, their numbers.

Each is compared with what plain Python gives. Nothing here is good style.
"""

# ruff: noqa: B007, D209, D301, E712, N801, SIM201, SIM300
import math
from typing import Annotated, NamedTuple

import numpy as np

from leadscrew.kernel.parameters import Doc, Unit


class int64_t(NamedTuple):
    """A class */ with a bad name ??/
    and ``*``/ a bad doc \u202e \\"""

    int: Annotated[float, Unit("m*/s"), Doc("why */ not ??/")] = 1.0
    int_: float = 2.0
    period: float = 3.0
    periods: float = 4.0
    new: float = 5.0
    NAN: float = 6.0
    DBL_EPSILON: float = 7.0
    µ: float = 8.0
    index: "int" = 3
    main: bool = True


class Names(NamedTuple):
    period: float = 1.0
    periods: float = 2.0
    double: float = 3.0
    inner: int64_t = int64_t()


def printf(x):
    return x + 1.0


def sqrt(x, y):
    return x * y + 0.5


def _helper(x):
    """Ends with a backslash \\
    and goes on ??/
    here. µ -> ∞ */ """
    return x * 3.0


def helper(x):
    return x * 5.0


def float_mod(x, y):
    return x + 2 * y


def axis_step(x):
    return x - 1.0


def conj(x):
    return -x


def carg(x, y):
    return -x * y


def double(x):
    return x * 2.0


def bad_names(p, s, command, feedback, dt, t):
    # a comment */ with an end ??/
    auto = command + p.period  # and \
    int_ = auto * 2.0
    params = int_ + s.periods
    state = params + p.inner.int
    r = state + p.inner.int_ + s.inner.µ
    value = r * 0.5
    ls_floor = math.floor(value)
    ls_sin = math.sin(ls_floor)
    isnan = 1.0 if ls_sin != ls_sin else 0.0
    axis_state = isnan + axis_step(ls_sin)
    NULL = axis_state + printf(value) + sqrt(value, 2.0)
    next = NULL + _helper(command) + helper(feedback) + float_mod(value, NULL) % 3.0
    true = next > 0.0
    M_PI = 3.0 if true else 4.0
    restrict = M_PI + conj(value) + carg(value, 2.0) + double(value)
    DBL_MAX = restrict * p.inner.NAN + p.inner.DBL_EPSILON
    x_ = DBL_MAX
    x = x_ + p.inner.index + p.inner.main + p.inner.new
    tuple2 = x
    Names_and_value = tuple2 * 0.5
    t1 = Names_and_value
    k1 = t1 + dt + t
    u5f = k1
    ü = u5f
    return s._replace(
        period=ü, periods=s.periods + 1.0, inner=s.inner._replace(int=ü, main=not s.inner.main, index=s.inner.index + 1)
    ), ü


def r(p, s, command):
    return s, command * 2.0 + s.period


def value(command):
    return command * 2.0


def params(p, command):
    return p.double * command


class Empty(NamedTuple):
    pass


class HasEmpty(NamedTuple):
    e: Empty = Empty()
    x: float = 0.0


def empties(p, s, command):
    return HasEmpty(s.e, s.x + 1.0), s.x + command


class Zero(NamedTuple):
    z: np.ndarray = np.zeros(0)
    y: float = 1.0


def zero_sized(p, s, command):
    return s, command + len(s.z) + p.y


class Motion(NamedTuple):
    position: float
    velocity: float
    n: int


class Out(NamedTuple):
    x: float
    on: bool
    k: int


def several(p, s, command, feedback):
    return s._replace(period=s.period + command.velocity), Out(
        command.position - feedback.position, command.n > feedback.n, command.n // 2
    )


def passed_on(m):
    return m.velocity * 2.0


def whole_signal(command, feedback):
    return passed_on(command) + feedback.position


def nothing():
    return 1.5


def only_t(t, dt):
    return t / dt


# ---- values
def huge(command, feedback):
    x = 1e308 * command * 10.0 + 5e-324 + 1e-45 + 2.0**53 + (-2.0) ** 63
    n = 2147483647 + 2147483648 + 4294967296 - 9223372036854775807
    return x + n * 1e-300 + (1 << 40) + (3 >> 1) + ((command > 0) << 33) + (1e39 if command > 1 else 3.5e38) + 16777217


def narrow(command, feedback):
    a = (2000000 if command > 0 else 1) * 100000
    b = (command > 0) * 2147483647 * 4
    c = -(2147483647 if command > 0 else -2147483647) - 10
    d = ~2147483647 - 5
    e = ((7 & 3) | 2147483647) * 3
    f = (command > 0) + (feedback > 0) + 2147483647
    return a + b + c + d + e + f


def bools(command, feedback):
    a = command > 0.0
    b = feedback > 0.0
    n = 3 if command > 1 else 2
    x = (
        (a == 2)
        + (a == b)
        + (a != True)
        + ((not a) == b)
        + ((not a) == 1)
        + (a < b)
        + (a <= True)
        + (True > b)
        + (a == 0.5)
        + (not a == 1)
    )
    y = ~a + -a + +a + abs(a) + (a & b) + (a | 2) + (a ^ True) + (a and b) * 2 + (a or n) + (n and 3.5) + (a + b == 2)
    z = (1 if a else 0) + (True if a else b) + bool(command) + int(a) + (1 if (2 if a else 4) else 0)
    w = (
        (command == command)
        + (n == n <= n)
        + (n >= n == True)
        + (feedback < feedback)
        + (0 < n < 3)
        + (a == a)
        + (command != command != 1)
    )
    while (n & 3) == 8:
        n += 1
    if n:
        x += 1
    if not command:
        x += 2
    return x * 1000.0 + y * 100.0 + z * 10.0 + w


def f_int(n):
    n = n * 0.5
    return n


def either(x):
    if x > 0:
        return 1, 2
    return pair(x)


def pair(x):
    return x, x * 2.0


def two(x):
    return (1, x) if x > 0 else (x, 2)


def grows(x, n):
    k = 0
    for i in range(3):
        k = f_only(k) + 0.5
    return k


def f_only(k):
    return k * 3


def typed(command, feedback):
    a, b = either(command)
    c, d = two(feedback)
    command + 1.0
    f_int(3)
    e = b
    g, h, i = a, c, d
    command = f_int(5) + f_int(command)
    return a + 10 * b + 100 * c + 1000 * d + command + grows(a, 2) + e + g + h + i


def loops(command, feedback):
    total = 0.0
    for i in range(3):
        for i in range(2):
            total = total * 2 + i
        total += 10 * i
    for i in range(5, -5, -3):
        if i == 2:
            continue
        if i < -3:
            break
        total += i
        i = 100
    j = 7
    for j in range(2):
        total += j
    total += j
    n = 3
    for k in range(0, n, 2):
        n = 10
        total += k
    step = -2
    for k in range(4, 0, step):
        step = 5
        total += k
    for k in range(3, 3):
        total += 1e9
    for k in range(0, 5, 0):
        total += 1e9
    m = 0
    while True:
        m += 1
        if m > 5:
            break
    while m > 0 and total < 1e6:
        m -= 2
        total *= 1.5
    return total + n + step + m + command


def divisions(command, feedback):
    n = -7 if command > 0 else 7
    m = 3 if feedback > 0 else -3
    z = 0 if command > 5 else 1
    return (
        (n // m) * 1e3
        + (n % m) * 1e2
        + n // z
        + n % z
        + n / m
        + (command // feedback)
        + (command % feedback)
        + (command // 0.3)
        + (command % -0.3)
        + (-7 // 2)
        + (-7 % 2)
        + 7 // -2
        + 7.5 // -2
    )


def extremes(command, feedback):
    return (
        max(command, feedback, 1)
        + min(command, 2, feedback)
        + abs(command)
        + abs(-3)
        + math.floor(command)
        + math.ceil(feedback)
        + round(command)
        + int(feedback)
        + math.copysign(1.0, command)
        + (np.inf if command > 3 else -np.inf if command < -3 else 0.0)
        + (np.nan if feedback == 3 else 0)
    )


def size_only(a):
    return len(a)


def unread(command, feedback):
    a = np.zeros(3)
    b = np.zeros((2, 3))
    n = 3
    m = 1
    if command > 0:
        m = 2
    x = 2.0 if n == n else 3.0
    y = 2.0 if m >= m else 3.0
    z = command
    for i in range(2):
        w = i
        z += 1.0 if w != w else 2.0
    return len(a) + b.shape[1] + x + y + z + size_only(a)


M = Motion(0.1, 0.2, 3)
STEPS = {
    f.__name__: (f, p, s, {})
    for f, p, s in (
        (r, Names(), Names()), (value, None, None), (params, Names(), None), (empties, Empty(), HasEmpty()),
        (zero_sized, Zero(), Zero()), (nothing, None, None), (only_t, None, None), (huge, None, None),
        (narrow, None, None), (bools, None, None), (typed, None, None), (loops, None, None), (divisions, None, None),
        (unread, None, None),
        (extremes, None, None), (bad_names, Names(), Names()),
    )
} | {
    "several": (several, Names(), Names(), {"command": M, "feedback": M}),
    "whole_signal": (whole_signal, None, None, {"command": M, "feedback": M}),
}  # fmt: skip
"""Step, parameters, state, examples of its signals."""
