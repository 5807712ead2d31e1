"""The portable functions: accurate against mpmath, the same bits in plain Python and in vectorised machine code."""

import functools
import itertools
import math
import platform
import subprocess
import sys

import mpmath
import numpy as np
import pytest
from mpmath import mp, mpf

from leadscrew.fuzzy.engine import execute
from leadscrew.kernel import bits, engines, portable
from leadscrew.kernel.lower import Lowering
from leadscrew.kernel.module import Module

RANKS = {"X": (2, "f"), "Y": (2, "f"), "J": (2, "i"), "K": (2, "i")}
INF, NAN = math.inf, math.nan
SPECIAL = np.array(
    [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, 2.0, -2.0, 2.5, 3.0, -3.0, INF, -INF, NAN, 5e-324, -5e-324,
     2.2250738585072014e-308, 2.225073858507201e-308, 1e-310, 1e-300, 1e-17, 1e-8, 1.7976931348623157e308,
     -1.7976931348623157e308, 1e300, 1e15, 2.0**31,
     2.0**51, 2.0**52 + 1, 2.0**53, 2.0**63, -(2.0**63), 709.782712893384, 709.79, -745.13, -745.2, 0.9999999999999999,
     1.0000000000000002, math.pi / 2, math.pi, 1e5, 1e7, 1e12, 1.1e12, -1e22, 4503599627370495.5, 0.49999999999999994]
)  # fmt: skip


def module_of(entry) -> Module:
    """A function of arrays as the entry of a generated module."""
    module = Module()
    module.entry(entry, entry.__name__)
    return module


def compiled(entry):
    """A function of arrays as machine code."""
    module = module_of(entry)
    return engines.by_llvm(module, entry.__name__, f"portable_{module.identity()}", RANKS)


@functools.cache
def loop_over(name: str, kind: str):
    """A portable function over the columns of an array, not yet compiled."""
    function = getattr(portable, name)
    x, y = "XY" if kind == "f" else "JK"
    arguments = ", ".join(f"{x}[{i}, k]" for i in range(function.__code__.co_argcount))
    value = f"function({arguments})" if kind == "i" else f"float(function({arguments}))"
    text = f"def loop({x}, {y}):\n    for k in range({x}.shape[1]):\n        {y}[0, k] = {value}\n    return 0\n"
    return execute(text, f"loop over {name}", {"function": function})["loop"]


def looped(name: str, inputs: list[np.ndarray]) -> np.ndarray:
    """A portable function over arrays, inside compiled code: the vectorised form."""
    x = np.array(inputs)
    y = np.empty((1, x.shape[1]), x.dtype)
    compiled(loop_over(name, "i" if x.dtype == np.int64 else "f"))(x, y)
    return y[0]


def patterns(x: np.ndarray) -> np.ndarray:
    """Bits of an array, with one pattern for every NaN: their signs differ between engines."""
    return np.where(np.isnan(x), NAN, x).view(np.int64) if x.dtype == np.float64 else x


def log_even(rng, low, high, n):
    """Points even in log scale, of both signs."""
    return np.exp(rng.uniform(math.log(low), math.log(high), n)) * rng.choice([-1.0, 1.0], n)


def any_double(rng, n):
    return rng.integers(-(2**63), 2**63 - 1, n).view(np.float64)


def near_quadrants(rng, n):
    """The doubles next to multiples of pi/2, up to 2**23 of them."""
    count = np.concatenate([np.arange(1, n // 2), rng.integers(1, 2**23, n // 2)])
    with mp.workprec(120):
        return np.array([float(int(k) * mp.pi / 2) for k in count]) * rng.choice([-1.0, 1.0], count.size)


def angles(rng):
    return np.concatenate([log_even(rng, 1e-9, 1.3e7, 300), rng.uniform(-10, 10, 300), near_quadrants(rng, 400)])


def positives(rng):
    near_one = 1 + log_even(rng, 1e-16, 0.3, 300)
    wide = np.abs(log_even(rng, 5e-324, 1.7e308, 300))
    return np.concatenate([wide, near_one, rng.uniform(0.3, 3, 300), [5e-324, 1e-310, 1.7e308]])


def exponents(rng):
    return np.concatenate([rng.uniform(-745, 709.7, 400), rng.uniform(-2, 2, 400), log_even(rng, 1e-20, 1, 200)])


def unit(rng):
    steep = 1 - np.abs(log_even(rng, 1e-16, 0.5, 200))
    return np.concatenate([rng.uniform(-1, 1, 500), log_even(rng, 1e-20, 1, 200), steep, -steep])


def moderate(rng):
    return np.concatenate([rng.uniform(-3, 3, 600), log_even(rng, 1e-20, 700, 400)])


def above_minus_one(rng):
    return np.concatenate([rng.uniform(-0.99, 3, 500), log_even(rng, 1e-20, 0.9, 400)])


ACCURACY = {
    "exp": (1.1, exponents, mpmath.exp),
    "expm1": (1.5, moderate, mpmath.expm1),
    "log": (0.9, positives, mpmath.log),
    "log2": (0.55, positives, lambda x: mpmath.log(x) / mpmath.log(2)),
    "log10": (0.55, positives, lambda x: mpmath.log(x) / mpmath.log(10)),
    "log1p": (1.6, above_minus_one, mpmath.log1p),
    "sin": (0.9, angles, mpmath.sin),
    "cos": (0.9, angles, mpmath.cos),
    "tan": (1.6, angles, mpmath.tan),
    "atan": (1.1, moderate, mpmath.atan),
    "asin": (0.9, unit, mpmath.asin),
    "acos": (0.9, unit, mpmath.acos),
    "tanh": (1.4, moderate, mpmath.tanh),
    "sinh": (1.7, moderate, mpmath.sinh),
    "cosh": (1.5, moderate, mpmath.cosh),
    "cbrt": (0.7, lambda rng: np.abs(log_even(rng, 5e-324, 1e308, 900)), mpmath.cbrt),
}
"""Function: the bound in its docstring (ulp), points, truth."""


def worst_ulp(got: np.ndarray, truths) -> float:
    return max(float(abs(mpf(float(g)) - t) / mpf(math.ulp(float(t)))) for g, t in zip(got, truths, strict=True))


@pytest.mark.parametrize("name", ACCURACY)
def test_error_against_mpmath_stays_within_the_stated_bound(name):
    bound, points, truth = ACCURACY[name]
    x = points(np.random.default_rng(7))
    assert f"{bound} ulp" in getattr(portable, name).__doc__
    with mp.workprec(110):
        assert worst_ulp(looped(name, [x]), [mpmath.re(truth(mpf(float(v)))) for v in x]) <= bound


def pow_inputs():
    rng = np.random.default_rng(8)
    near_one = 1 + log_even(rng, 1e-15, 0.3, 400)
    x = np.concatenate([np.abs(log_even(rng, 1e-300, 1e300, 500)), rng.uniform(0, 3, 600), near_one])
    largest = np.minimum(1e18, 1021.9 / np.maximum(np.abs(np.log2(x)), 1e-17))
    near_limit = rng.choice([-1, 1], x.size) * rng.uniform(0.9, 1, x.size) * largest
    y = np.where(rng.random(x.size) < 0.5, near_limit, rng.uniform(-1, 1, x.size) * np.minimum(largest, 5))
    return x, y


def test_pow_atan2_and_hypot_against_mpmath():
    rng = np.random.default_rng(9)
    plane = [np.concatenate([log_even(rng, 1e-300, 1e300, 300), rng.uniform(-3, 3, 600)]) for _ in range(2)]
    for name, bound, (x, y), truth in (
        ("pow", 1.6, pow_inputs(), mpmath.power),
        ("atan2", 1.6, plane, mpmath.atan2),
        ("hypot", 1.2, plane, mpmath.hypot),
    ):
        assert f"{bound} ulp" in getattr(portable, name).__doc__
        with mp.workprec(110):
            truths = [truth(mpf(float(a)), mpf(float(b))) for a, b in zip(x, y, strict=True)]
            kept = [i for i, t in enumerate(truths) if abs(t) > 1e-307]
            got = looped(name, [x, y])
            assert worst_ulp(got[kept], [truths[i] for i in kept]) <= bound, name


UNARY = [*ACCURACY, "fabs", "sign", "sqrt", "floor", "ceil", "trunc", "round_half_even", "flush", "to_int", "is_finite",
         "is_nan", "is_infinite"]  # fmt: skip
BINARY = ["pow", "atan2", "hypot", "copysign", "maximum", "minimum", "float_mod", "float_floordiv"]


@pytest.mark.parametrize("name", UNARY)
def test_machine_code_gives_the_bits_of_plain_python(name):
    rng = np.random.default_rng(10)
    x = np.concatenate([SPECIAL, any_double(rng, 6000), rng.uniform(-3, 3, 9000), log_even(rng, 1e-12, 1e12, 4960)])
    got = looped(name, [x])
    expected = np.array([getattr(portable, name)(v) for v in x.tolist()], got.dtype)
    assert np.array_equal(patterns(got), patterns(expected))


@pytest.mark.parametrize("name", BINARY)
def test_machine_code_gives_the_bits_of_plain_python_for_two_arguments(name):
    rng = np.random.default_rng(11)
    pairs = np.array(list(itertools.product(SPECIAL, SPECIAL)))
    more = [[any_double(rng, 4000), rng.uniform(0, 3, 9000), log_even(rng, 1e-12, 1e12, 5000)] for _ in range(2)]
    x, y = (np.concatenate([pairs[:, i], *more[i]]) for i in (0, 1))
    got = looped(name, [x, y])
    expected = np.array([getattr(portable, name)(a, b) for a, b in zip(x.tolist(), y.tolist(), strict=True)])
    assert np.array_equal(patterns(got), patterns(expected))


@pytest.mark.parametrize("name", ["int_mod", "int_floordiv"])
def test_integer_division_is_that_of_python_in_machine_code_too(name):
    rng = np.random.default_rng(12)
    large = 2**53
    a = np.concatenate([rng.integers(-50, 50, 9000), rng.integers(-large, large, 12000), [large, -large, large - 1]])
    b = np.concatenate([rng.integers(-9, 9, 15000), rng.integers(-large, large, 6000), [1, 1, -1]])
    ours = np.array([getattr(portable, name)(i, j) for i, j in zip(a.tolist(), b.tolist(), strict=True)])
    operator = {"int_mod": lambda i, j: i % j, "int_floordiv": lambda i, j: i // j}[name]
    assert ours.tolist() == [operator(i, j) if j else 0 for i, j in zip(a.tolist(), b.tolist(), strict=True)]
    assert np.array_equal(looped(name, [a, b]), ours)


def c_library(function, *args):
    """The C99 value: NaN where Python raises a domain error, infinity where it reports overflow."""
    try:
        return function(*args)
    except OverflowError:
        return None
    except (ValueError, ZeroDivisionError):
        return NAN


def same(a, b):
    return (a != a and b != b) or (a == b and math.copysign(1, a) == math.copysign(1, b))


def same_within_an_ulp(a, b):
    return same(a, b) or (math.copysign(a, b) == a and abs(a - b) <= math.ulp(b) < INF)


def test_special_values_of_pow_and_atan2_are_those_of_c99():
    exact = [0.0, -0.0, 1.0, -1.0, INF, -INF, NAN, 2.0, -2.0, 0.5, -0.5, 3.0, -3.0, 2.0**53, 1e300, -1e300, 5e-324]
    for x, y in itertools.product(exact, exact):
        expected = c_library(math.pow, x, y)
        if x == 0 and y < 0:
            expected = math.copysign(INF, x) if y == int(max(y, -1e300)) and y % 2 == 1 else INF
        if expected is None:
            assert abs(portable.pow(x, y)) == INF
        else:
            assert same_within_an_ulp(portable.pow(x, y), expected), (x, y)
        assert same_within_an_ulp(portable.atan2(x, y), math.atan2(x, y)), (x, y)


def test_special_values_of_the_others():
    p = portable
    for name in "sin tan atan asin tanh sinh expm1 log1p cbrt sqrt floor ceil trunc round_half_even".split():  # noqa: SIM905
        f = getattr(p, name)
        assert same(f(-0.0), -0.0) and same(f(0.0), 0.0), f
    for f in (p.sin, p.cos, p.tan):
        assert all(math.isnan(f(v)) for v in (INF, -INF, NAN, 2e12))
        assert all(abs(f(v) - getattr(math, f.__name__)(v)) < 1e-3 for v in (1e9, 9.9e11))
    for f in (p.log, p.log2, p.log10, p.sqrt):
        assert math.isnan(f(-1.0)) and math.isnan(f(NAN)) and f(INF) == INF
    assert (p.log(0.0), p.log1p(-1.0), p.exp(-INF), p.exp(INF), p.expm1(-INF)) == (-INF, -INF, 0.0, INF, -1.0)
    assert (p.tanh(INF), p.tanh(-INF), p.sinh(-INF), p.cosh(-INF), p.hypot(INF, NAN)) == (1.0, -1.0, -INF, INF, INF)
    assert math.isnan(p.asin(1.1)) and math.isnan(p.acos(-1.1)) and math.isnan(p.log1p(-1.1))
    assert (p.to_int(NAN), p.to_int(INF), p.to_int(-1e300), p.to_int(-2.9)) == (0, 2**63 - 2**39, 2**39 - 2**63, -2)
    assert (p.flush(1e-301), p.flush(-1e-301), p.flush(1e-299)) == (0.0, 0.0, 1e-299)


@pytest.mark.parametrize("other", [0.0, -3.0, INF, NAN])
@pytest.mark.parametrize("infinite", [INF, -INF])
def test_a_length_with_an_infinite_side_is_infinite_whatever_the_other_side_is(infinite, other):
    assert portable.hypot(infinite, other) == portable.hypot(other, infinite) == math.hypot(infinite, other) == INF


def test_exact_results_where_a_user_expects_them():
    for n in range(-300, 309):
        assert portable.log10(float(f"1e{n}")) == n
    for n in range(-1074, 1024):
        assert portable.log2(math.ldexp(1, n)) == n and portable.pow(2.0, float(n)) == math.ldexp(1, n)
    for n in range(1, 60):
        assert portable.pow(float(n), 2.0) == n * n and portable.cbrt(float(n**3)) == n


def test_rounding_and_float_division_are_those_of_python():
    rng = np.random.default_rng(13)
    wide = log_even(rng, 1e-3, 1e17, 2000)
    x = np.concatenate([rng.uniform(-9, 9, 3000), rng.integers(-20, 20, 500) / 2, wide]).tolist()
    for ours, theirs in (("floor", math.floor), ("ceil", math.ceil), ("trunc", math.trunc), ("round_half_even", round)):
        assert all(getattr(portable, ours)(v) == theirs(v) for v in x)
    special = itertools.product(SPECIAL.tolist(), SPECIAL.tolist())
    for a, b in itertools.chain(zip(x, reversed(x), strict=True), special):
        if b != 0 and abs(a) < INF and abs(a / b if abs(b) > 1e-290 else INF) < 2**51:
            assert same(portable.float_mod(a, b), a % b), (a, b)
            assert same(portable.float_floordiv(a, b), a // b), (a, b)
    assert math.isnan(portable.float_mod(1.0, 0.0)) and math.isnan(portable.float_floordiv(1e300, 1.0))


@pytest.mark.parametrize("name", ["exp", "log", "tanh", "atan", "cbrt", "sinh"])
def test_rising_functions_rise_between_neighbours_a_few_ulp_apart(name):
    f = getattr(portable, name)
    for start in (0.3, 0.4142, 0.5, 0.7071, 0.9999999, 1.0, 1.4142, 7.9):
        x = [start * (1 + 64 * i * 2.0**-52) for i in range(200)]
        assert all(f(a) <= f(b) for a, b in itertools.pairwise(x)), start


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="x86-64: reads its assembly")
@pytest.mark.parametrize("name", ["exp", "sin", "pow"])
def test_hot_functions_vectorise(name):
    module = module_of(loop_over(name, "f"))
    optimised = engines.optimised(Lowering(module.fused("loop"), RANKS, module.arrays()).run())
    assert engines._machine()[0].emit_assembly(optimised).count("mulpd") > 5


def total(X, Y):
    table = bits.stack_array2(2, 16)
    row = bits.stack_array2(1, 16)
    for lane in range(16):
        table[0, lane] = 0.5 * lane
        table[1, lane] = X[0, 0]
        row[0, lane] = 1.0
    Y[0, 0] = 0.0
    for lane in range(16):
        Y[0, 0] = Y[0, 0] + table[0, lane] * table[1, lane] + row[0, lane]
    return 0


def test_arrays_on_the_stack():
    for run in (total, compiled(total)):
        y = np.empty((1, 1))
        run(np.array([[3.0]]), y)
        assert y == 196.0


def test_bits_go_both_ways_without_numpy():
    assert [bits.float_to_bits(v) for v in (0.0, 1.0, -0.0)] == [0, 0x3FF0000000000000, -(2**63)]
    assert all(bits.bits_to_float(bits.float_to_bits(v)) == v for v in SPECIAL.tolist() if v == v)
    source = "import sys, leadscrew.kernel.portable; assert not {'numpy', 'llvmlite'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", source], check=True)
