"""Steps that engines would differ in, and what is said of each."""

import math

import numpy as np

from tests.kernel.hostile import BOARD, COUNTS, TABLE

BEYOND, TEXTS, COMPLEX = np.array([2**63], dtype=np.uint64), np.array(["a"]), np.array([1j])
HUGE = 2**64


# ---- arrays: refused
def rebinds_under_if(p, s, command):
    t = s.a
    if command > 0.5:
        t = s.b
    return s, t[0]


def rebinds_in_a_loop(p, s, command):
    t, u = s.a, 0.0
    for _ in range(3):
        u += t[0]
        t = s.b
    return s, u


def one_by_branch(p, s, command):
    if command > 0.5:
        t = s.a
    else:
        t = np.zeros(3)
        t[0] = command
    return s, t[0]


def chooses(p, s, command):
    t = s.a if command > 0.5 else s.b
    return s, t[0]


def chooses_and_reads(p, s, command):
    return s, (s.a if command > 0.5 else s.b)[1]


def chooses_a_state(p, s, command):
    t = s if command > 0.5 else s._replace(x=command)
    return t, t.a[0]


def first_of(a):
    return a[0]


def chooses_an_argument(p, s, command):
    return s, first_of(s.a if command > 0.5 else s.b)


def one_or_other(a, b, x):
    if x > 0.5:
        return a
    return b


def returns_one_or_other(p, s, command):
    return s, one_or_other(s.a, s.b, command)[0]


def swaps_under_if(p, s, command):
    if command > 0.5:
        s = s._replace(a=s.b, b=s.a)
    return s, s.a[0]


def returns_swapped_late(p, s, command):
    if command > 0.9:
        return s._replace(a=s.b), 1.0
    return s, s.a[0]


def returns_fresh_late(p, s, command):
    if command > 0.9:
        return s._replace(a=np.zeros(3)), 1.0
    return s, s.a[0]


def writes_parameters(p, s, command):
    if command > 0.9:
        p.weights[0] = command
    return s, p.weights[0]


def put_first(a, x):
    a[0] = x
    return x


def writes_a_table_by_a_helper(p, s, command):
    return s, put_first(TABLE, command)


def writes_parameters_by_a_name(p, s, command):
    w = p.weights
    w[1] += command
    return s, w[1]


def takes_a_row(p, s, command):
    row = BOARD[p.n - 2]
    return s, row[0]


def takes_a_constant_row(p, s, command):
    row = BOARD[1]
    return s, row[0]


def adds_arrays(p, s, command):
    return s, (s.a + s.b)[0] + command


def compares_arrays(p, s, command):
    return s, 1.0 if s.a == s.b else command


def sine_of_an_array(p, s, command):
    t = math.sin(s.a) if command > 2.0 else command
    return s, t


def attribute_of_an_array(p, s, command):
    return s, s.a.size + command


def number_or_array(p, s, command):
    t = 1.0
    if command > 0.5:
        t = s.a
    return s, 1.0 if command > 2.0 else first_of(t)


def indexes_a_float(p, s, command):
    return s, (s.x if command < 2.0 else s.a[s.x])


def size_by_a_variable(p, s, command):
    return s, s.a.shape[p.n - 3] + command


def tuple_in_a_local(p, s, command):
    t = command, 2.0
    a, b = t
    return s, a + b


# ---- whole numbers: refused
def index_from_a_table(p, s, command):
    return s, s.a[COUNTS[p.n - 3] - 1] + command


def float_index_later(p, s, command):
    k = 1
    if command > 0.9:
        k = k * 0.5
    return s, s.a[k]


def bits_of_a_float(p, s, command):
    return s, (COUNTS[p.n - 1] & 1) + command


def range_of_a_float(p, s, command):
    u = command
    for _ in range(COUNTS[p.n - 1]):
        u += 1.0
    return s, u


def huge_global(p, s, command):
    return s, command + HUGE


def helper_with_default(x, huge=2**64):
    return x + huge


def huge_default(p, s, command):
    return s, helper_with_default(command)


def unsigned_table(p, s, command):
    return s, command + BEYOND[p.n - 3]


def text_table(p, s, command):
    return s, command + len(TEXTS)


def complex_table(p, s, command):
    return s, command + COMPLEX[0]


def minus_a_choice(p, s, command):
    return s, math.copysign(1.0, -(0 if command > 0.5 else s.x * 0.0))


def minus_a_maximum(p, s, command):
    return s, math.copysign(1.0, -max(0, -command))


def minus_a_sum(p, s, command):
    total = 0
    for i in range(s.n - 2):
        total += s.a[i]
    return s, math.copysign(1.0, -total)


def times_a_choice(p, s, command):
    return s, math.copysign(1.0, (0 if command > 0.5 else s.x) * -p.n)


def mixed_remainder(p, s, command):
    return s, math.copysign(1.0, (0 if command > 0.5 else s.x) % -3)


def two_kinds(x):
    if x > 0.5:
        return x
    return x, x


def returns_two_kinds(p, s, command):
    return s, 1.0 if command < 2.0 else two_kinds(command)


REFUSED = {
    rebinds_under_if: "one array on one path", rebinds_in_a_loop: "one array on one path",
    one_by_branch: "one array on one path", chooses: "a choice between arrays",
    chooses_and_reads: "a choice between arrays", chooses_a_state: "a choice between arrays",
    chooses_an_argument: "a choice between arrays", returns_one_or_other: "holds another array",
    swaps_under_if: "another array as 'a'|one array on one path", returns_swapped_late: "another array as 'a'",
    returns_fresh_late: "another array as 'a'", writes_parameters: r"a write into the parameters \(weights\)",
    writes_a_table_by_a_helper: r"a write into a constant table \(TABLE\)",
    writes_parameters_by_a_name: "a write into the parameters", takes_a_row: r"1 index\(es\) into an array of 2",
    takes_a_constant_row: r"1 index\(es\) into an array of 2", adds_arrays: "no number here",
    compares_arrays: "no number here", sine_of_an_array: "no number here", attribute_of_an_array: "no field 'size'",
    number_or_array: "a number, an array", indexes_a_float: r"write int\(...\)",
    index_from_a_table: r"an index by the float .*write int\(...\)", float_index_later: r"write int\(...\)",
    bits_of_a_float: r"bits of the float .*write int\(...\)", range_of_a_float: r"range\(\) of the float",
    huge_global: "whole number 18446744073709551616; .* 64 bits", huge_default: "64 bits",
    unsigned_table: "array of uint64", text_table: "array of <U1", complex_table: "array of complex128",
    minus_a_choice: "'-' of what is a whole number on one path", minus_a_maximum: "write 0.0 for 0",
    minus_a_sum: "write 0.0 for 0", times_a_choice: "write 0.0 for 0", mixed_remainder: "write 0.0 for 0",
    returns_two_kinds: "of another kind", tuple_in_a_local: "a tuple in the local 't'",
    size_by_a_variable: r"write .shape\[0\]",
}  # fmt: skip
