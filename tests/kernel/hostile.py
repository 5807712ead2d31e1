"""Steps that would mean different things to different engines, were each to read them by itself."""

from typing import NamedTuple

import numpy as np

COUNTS = np.array([3, -1, 2])
TABLE = np.array([1.5, -2.0, 4.0])
BOARD = np.array([[1.0, 2.0], [3.0, 4.0]])
LEAST, LARGE_COUNTS = -(2**63), np.array([2**62, 2**53 + 1, -(2**63)])


class P(NamedTuple):
    n: int = 3
    d: int = -1
    gain: float = 0.5
    weights: np.ndarray = np.array([1.0, 2.0])


class S(NamedTuple):
    x: float = 0.25
    n: int = 2
    on: bool = True
    a: np.ndarray = np.array([1.0, 2.0, 3.0])
    b: np.ndarray = np.array([-1.0, -2.0, -3.0])


def comparisons_are_counted(p, s, command):
    x = (s.x > 0) + (s.x > 0.1) + (s.a[0] > 0) + (TABLE[0] > 0) + (p.gain > 0) * 2 + s.on + s.on
    return s, x + -s.on + ~s.on + (s.a[1] == 2.0) * 8 + (0 < s.x < 1) + np.isfinite(s.x) + np.isnan(s.x) + command


def truth_kept_in_a_local(p, s, command):
    up, high = s.x > 0.0, s.a[2] > 2.5
    both = up & high
    return s._replace(on=not s.on), (up + high + both) * 10 + -up + (up == high) + command


def whole_tables(p, s, command):
    return s, COUNTS[1] // 0 + COUNTS[0] % 0 + COUNTS[1] // 2 + COUNTS[-2] % 5 + (COUNTS[0] & 2) + s.a[COUNTS[2]]


def float_from_a_table(p, s, command):
    return s, 1.0 if COUNTS[p.n - 2] // (p.n - 3) == 0 else command


def index_made_whole(p, s, command):
    return s, s.a[int(COUNTS[p.n - 1])] + s.a[int(COUNTS[p.n + 9])] + command


def read_of(t, i):
    return t[i]


def tables_by_a_helper(p, s, command):
    return s, read_of(COUNTS, 1) // (p.n - 3) + read_of(TABLE, p.n - 2) + command


def wraps(p, s, command):
    large = LEAST + s.n
    x = (large - 7) * 1e-19 + (large * 3) * 1e-19 + (large * large) * 1e-19 + -(LEAST - 0 * p.n) * 1e-19
    y = (large << 1) * 1e-19 + (p.n**41) * 1e-19 + abs(LEAST + 0 * p.n) * 1e-19
    for _ in range(5):
        large += large
    return s._replace(n=s.n + 1), x + y + large + command


def wraps_before_a_shift(p, s, command):
    large = LEAST + s.n
    return s, ((large + large) >> 1) * 1e-19 + ((large * 2) // 2) + command


def least_by_minus_one(p, s, command):
    least, k = LEAST + 0 * p.n, p.n - 10
    return s, least // p.d * 1e-19 + least % p.d + k // p.d + k % p.d + command


def large_whole_numbers(p, s, command):
    n = LARGE_COUNTS[1] + 0 * p.n
    return s, n / 3 + (n == 9007199254740992.0) + (n > s.x) + (n - 9007199254740992) + LARGE_COUNTS[0] * 1e-18 + command


def ranges_to_the_end(p, s, command):
    total, last = command, 2**62 - 1 + 2**62
    for i in range(last - 5, last, p.n):
        total += i % 7
    for i in range(last - 5, last - p.n + 3, 4):
        total += i % 7
    for i in range(LEAST + 5, LEAST, -p.n):
        total += i % 7
    return s, total


def one_array_in_each_branch(p, s, command):
    t = s.a
    if command > 0.5:
        t = s.b
        t[1] = command
    else:
        x = t[0]
        t = s.b
        t[2] = x
    return s, t[1] + t[2] + s.a[0]


def rebinds_in_a_row(p, s, command):
    t = s.a
    x = t[0]
    t = s.b
    t[0] = command
    return s, x + t[0] + t[1]


def each_in_its_branch(p, s, command):
    if command > 0.5:
        t = s.a
        x = t[0]
    else:
        t = s.b
        x = t[1]
        t[0] = command
    return s, x + s.b[0]


def moved(s, x):
    if x > 0.5:
        s.a[0] = x
        return s
    return S(x, s.n + 1, s.on, s.a, s.b)


def state_through_a_helper(p, s, command):
    s = moved(s, command)
    for _ in range(2):
        s = moved(s, s.a[0] * 0.5)
    return s, s.x + s.a[0]


def stepped(p, s, x):
    s = moved(s, x)
    return s, s.x * p.gain


def both_through_a_helper(p, s, command):
    y = 0.0
    for i in range(3):
        if command > 0.1 * i:
            s, y = stepped(p, s, command)
        else:
            y = 0.5
    if command > 0.3:
        return stepped(p, s, y)
    return s, y


def own_room(x):
    room = np.zeros(2)
    room[0] = x
    return room


def two_rooms(p, s, command):
    a, b = own_room(command), own_room(2.0)
    b[1] = a[0]
    c = np.empty(2)
    return s, a[0] + 10.0 * b[0] + 100.0 * b[1] + 1000.0 * c[1] + s.a.shape[-1]


def kept(x, ret0, done1):
    whole_1 = x
    for i in range(3):
        ret = i * done1
        if ret > x:
            return ret + whole_1, ret0
        done1 += ret0
    v_1 = done1 + ret0
    return v_1, whole_1


def names_of_the_fuser(p, s, command):
    kept_1, v__x = kept(command, 1.0, 0.5)
    t = s._replace(x=s.a[0], n=s.n + 1)
    t__x, t__n = 5.0, 7
    u = t._replace(x=t.n * 1.0, n=int(t.x))
    t = t._replace(x=u.x, n=u.n)
    return s, kept_1 + v__x + t__x + t__n + t.x + t.n * 100 + u.x * 1000


def pairs_by_condition(p, s, command):
    a, b = (command, 1) if command > 0.5 else (2, command)
    c, d = pair_of(command) if command > 0.2 else ((a, b) if s.on else (b, a))
    return s, a * 2 + b - c * 3 + d * 5


def pair_of(x):
    return (x, x * 2.0) if x > 0.6 else (1.0, x)


def indexed_by_truth(p, s, command):
    s.b[command > 0.5] = command
    return s, s.a[command > 0.5] + s.a[s.on] * 2 + TABLE[True] * 4 + COUNTS[False] + BOARD[s.on, command > 0.3]


def ints_and_floats(p, s, command):
    k = 0
    for i in range(3):
        k = k + 0.5 if i else k + 1
    return s, k * 2 + abs(k) + max(k, p.n) + min(p.n, 2) / 4 + command


SAME = [
    comparisons_are_counted, truth_kept_in_a_local, whole_tables, float_from_a_table, index_made_whole,
    tables_by_a_helper, wraps, wraps_before_a_shift, least_by_minus_one, large_whole_numbers, ranges_to_the_end,
    rebinds_in_a_row, each_in_its_branch, one_array_in_each_branch, state_through_a_helper, both_through_a_helper,
    two_rooms, names_of_the_fuser, ints_and_floats, pairs_by_condition, indexed_by_truth,
]  # fmt: skip
