"""Our own lowering to machine code against plain Python, operation by operation; and what it refuses."""

import ast
import hashlib
import itertools
import math
import struct
import types

import numpy as np
import pytest

from leadscrew.kernel import bits, engines
from leadscrew.kernel.drivers import hooks
from leadscrew.kernel.lower import Lowering
from leadscrew.kernel.source import tree_of
from leadscrew.util.errors import SubsetError

RANKS = {"N2": (2, "i"), "J": (2, "i"), "F": (2, "f"), "G": (2, "f"), "A": (1, "f"), "N": (1, "i")}
WEIGHTS = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
COUNTS = np.array([3, 1, 2])
CONSTANTS = {"WEIGHTS": WEIGHTS, "COUNTS": COUNTS}


def machine_code(function):
    """A function of arrays as machine code, lowered as it stands."""
    node, _ = tree_of(function)
    title = "loop_" + hashlib.sha256(ast.unparse(node).encode()).hexdigest()[:24]
    names = [a.arg for a in node.args.args]
    module = types.SimpleNamespace(
        fused=lambda _: node, arrays=lambda: CONSTANTS, arguments_of=lambda _: names, identity=lambda: title
    )
    return engines.by_llvm(module, function.__name__, title, RANKS)  # type: ignore[arg-type]


def lower(text: str) -> None:
    node = ast.parse(text).body[0]
    assert isinstance(node, ast.FunctionDef)
    Lowering(node, RANKS, CONSTANTS).run()


INTS = [0, 1, -1, 2, -2, 3, -3, 7, -7, 10, -10, 2**31, -(2**31), 2**52 + 1, -(2**62), 2**63 - 1]


def integers(N2, J):
    for r in range(N2.shape[0]):
        a = N2[r, 0]
        b = N2[r, 1]
        J[r, 0] = a // b
        J[r, 1] = a % b
        J[r, 2] = abs(a)
        J[r, 3] = (a & b) + (a | b) * 0
        J[r, 4] = a | b
        J[r, 5] = a ^ b
        J[r, 6] = ~a
        J[r, 7] = -b
        J[r, 8] = a >> 3
        J[r, 9] = (b & 1023) << 5
        J[r, 10] = bool(a)
        J[r, 11] = not b
        J[r, 12] = (a < b) + 2 * (a <= b) + 4 * (a == b) + 8 * (a != b) + 16 * (a > b) + 32 * (a >= b)
        J[r, 13] = abs(a > b) + (-(a > b)) * 4 + (+(a > b)) * 16
        J[r, 14] = (a > 0) & (b > 0) | (a < 0) ^ (b < 0)
        J[r, 15] = int(a > 0 and b > 0) + 2 * int(a > 0 or b > 0)


def by_hand(a: int, b: int) -> list[int]:
    quotient, rest = divmod(a, b) if b else (0, 0)
    return [
        quotient, rest, abs(a), a & b, a | b, a ^ b, -a - 1, 0 - b, math.floor(a / 8) if abs(a) < 2**50 else a // 8,
        (b % 1024) * 32, int(a != 0), int(b == 0),
        (a < b) + 2 * (a <= b) + 4 * (a == b) + 8 * (a != b) + 16 * (a > b) + 32 * (a >= b), 13 * int(a > b),
        int((a > 0 and b > 0) or ((a < 0) != (b < 0))), int(a > 0 and b > 0) + 2 * int(a > 0 or b > 0),
    ]  # fmt: skip


def test_integers_divide_shift_and_compare_as_python_has_them_and_give_0_over_0():
    pairs = np.array(list(itertools.product(INTS, repeat=2)))
    got = np.full((len(pairs), 16), -99)
    machine_code(integers)(pairs, got)
    for (a, b), row in zip(pairs.tolist(), got.tolist(), strict=True):
        assert row == by_hand(a, b), (a, b)


FLOATS = [
    0.0, -0.0, 1.0, -1.0, 0.1, -0.1, 0.3, 2.5, -2.5, 7.0, -7.5, 1e-310, -5e-324, 1e16, -1e16 - 2, 1e308, -1e308,
    math.pi, math.inf, -math.inf, math.nan,
]  # fmt: skip


def floats(F, G):
    for r in range(F.shape[0]):
        a = F[r, 0]
        b = F[r, 1]
        G[r, 0] = a // b
        G[r, 1] = a % b
        G[r, 2] = abs(a)
        G[r, 3] = -b
        G[r, 4] = a / b
        G[r, 5] = (a < b) + 2 * (a <= b) + 4 * (a == b) + 8 * (a != b) + 16 * (a > b) + 32 * (a >= b)
        G[r, 6] = bool(a) + 2 * (not b)
        G[r, 7] = +a
        G[r, 8] = ieee_select(a < b, 1, b)  # noqa: F821
        G[r, 9] = bits_to_float(float_to_bits(a) ^ 1)  # noqa: F821
        G[r, 10] = math.sqrt(abs(b))


def same_number(x: float, y: float) -> bool:
    return (x != x and y != y) or struct.pack("<d", x) == struct.pack("<d", y)


def test_floats_divide_and_compare_as_python_has_them_to_the_last_bit_and_ieee_by_zero():
    pairs = np.array(list(itertools.product(FLOATS, repeat=2)))
    got = np.zeros((len(pairs), 11))
    machine_code(floats)(pairs, got)
    for (a, b), row in zip(pairs.tolist(), got.tolist(), strict=True):
        with np.errstate(all="ignore"):
            ieee = float(np.float64(a) / np.float64(b))
        flipped = bits.bits_to_float(bits.float_to_bits(a) ^ 1)
        want = [
            a // b if b else ieee, a % b if b else math.nan, abs(a), -b, ieee,
            (a < b) + 2 * (a <= b) + 4 * (a == b) + 8 * (a != b) + 16 * (a > b) + 32 * (a >= b),
            bool(a) + 2 * (not b), a, 1.0 if a < b else b, flipped, math.sqrt(abs(b)),
        ]  # fmt: skip
        for i, (x, y) in enumerate(zip(row, want, strict=True)):
            assert same_number(x, y), (a, b, i, x, y)


def statements(A, N):
    k = 0
    odd = 0
    while k < 10:
        k = k + 1
        if k % 2 == 0:
            continue
        if k > 7:
            break
        odd = odd + k
    N[0] = odd
    N[1] = k
    down = 0
    for i in range(9, 1, -3):
        down = down * 10 + i
    N[2] = down
    for i in range(1, 10, 4):
        down = down + i
    N[3] = down
    scratch = np.zeros((2, 3))
    scratch[1, 2] = 4.5
    scratch[0, -1] = 2.0
    A[0] = scratch[1, 2] + 10.0 * scratch[0, 2] + 100.0 * scratch[0, 0]
    room = np.empty(2)
    room[0] = 1
    room[-1] = 2.5
    A[1] = room[0] + room[1]
    A[2] = WEIGHTS[1, 2] + WEIGHTS[-2, 0] + COUNTS[-1] / 4
    N[4] = COUNTS[0] * 100 + len(A) * 10 + WEIGHTS.shape[1]
    if True:  # noqa: SIM108
        mixed = 1
    else:
        mixed = 7
    if A[3] > 0.0:
        mixed = 2.5
    A[4] = mixed
    A[5] = True
    A[6] = np.inf
    A[7] = np.nan
    N[5] = int(A[3] * 1e3)
    N[6] = float(3) > 2
    if A[3] > 0.0:
        return 0
        A[8] = 99.0
    else:
        if A[3] < -5.0:
            return 0
        else:
            return 0


@pytest.mark.parametrize("x", [1.5, -1.5, -8.25])
def test_loops_local_arrays_frozen_tables_and_jumps_do_what_python_does(x):
    made, want = ((np.full(9, x), np.zeros(8, dtype=np.int64)) for _ in range(2))
    assert machine_code(statements)(*made) == 0
    statements(*want)
    np.testing.assert_array_equal(made[0], want[0])
    assert made[1].tolist() == want[1].tolist()
    assert want[1].tolist()[:5] == [1 + 3 + 5 + 7, 9, 963, 963 + 15, 393]


def viewed(F, G):
    room = np.zeros((2, 8))
    flat = room[0]
    flat[0] = F[1, 2]
    part = flat[2:5]
    part[0] = 7.0
    square = flat[4 : 2 * 4].reshape(2, 2)
    square[1, 0] = 3.0
    square[0, 1] = len(square) + square.shape[1] * 10.0
    for i in range(2):
        for j in range(8):
            G[i, j] = room[i, j]


def test_views_of_rows_and_stretches_write_into_the_array_they_view():
    F = np.arange(6.0).reshape(2, 3)
    made, want = np.zeros((2, 8)), np.zeros((2, 8))
    machine_code(viewed)(F, made)
    viewed(F, want)
    np.testing.assert_array_equal(made, want)
    assert made[0].tolist() == [5.0, 0.0, 7.0, 0.0, 0.0, 22.0, 3.0, 0.0] and not made[1].any()


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("del A", "a statement outside the subset"),
        ("a, b = A[0], A[1]", "a tuple that was not taken apart"),
        ("x = A[0] if A[1] > 0 else 1.0", "an array that cannot be traced"),
        ("A[0] = A[0] if A[1] > 0 else 1.0", "an expression outside the subset"),
        ("A[0] = missing", "a name that is not set"),
        ("A[0] = A", "an array where a number is needed"),
        ("A[0] = p.x", "a field of something that was not taken apart"),
        ("A[0] = A[1] ** 2.0", "an operator outside the subset"),
        ("A[0] = other(A[1])", "a call of 'other' that was not fused"),
        ("A[0] = A[1, 0]", "2 indices into an array of 1 dimensions"),
        ("A[0] = COUNTS[3]", "the index 3 into an array of 3"),
        ("A[0] = COUNTS[-4]", "the index -4 into an array of 3"),
        ("x = np.zeros(N[0])", "a size that is not constant"),
        ("x = np.zeros((2, N[0]))", "a size that is not constant"),
    ],
)
def test_what_cannot_be_lowered_is_refused_in_one_sentence_with_its_text(body, says):
    with pytest.raises(SubsetError, match=says) as caught:
        lower(f"def f(A, N):\n    {body}\n")
    assert str(caught.value).startswith("f: ") and "\n" not in str(caught.value)


def test_machine_code_takes_only_arrays_laid_out_as_it_reads_them():
    entry = machine_code(statements)
    with pytest.raises(TypeError, match="expected a contiguous float64 array of 1 dimensions"):
        entry(np.zeros(9, dtype=np.float32), np.zeros(8, dtype=np.int64))
    with pytest.raises(TypeError, match="int64"):
        entry(np.zeros(9), np.zeros(8))
    with pytest.raises(TypeError, match="contiguous"):
        entry(np.zeros(18)[::2], np.zeros(8, dtype=np.int64))


HOOKS = [
    f
    for f in vars(hooks).values()
    if isinstance(f, types.FunctionType) and f.__module__ == hooks.__name__ and f.__name__ != "_open"
]


@pytest.mark.parametrize("hook", HOOKS, ids=lambda f: f.__name__)
def test_a_hook_that_nobody_linked_says_so_when_called(hook):
    with pytest.raises(NotImplementedError, match="called before it was linked"):
        hook(*range(hook.__code__.co_argcount))


def test_a_constant_that_nobody_linked_cannot_be_counted_with():
    with pytest.raises(TypeError, match="the hook LANES is not linked"):
        range(hooks.LANES)
