"""References of the grey models that share nothing with the code under test: exact rationals, 50 digits, matrices."""

import csv
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np

VECTORS = Path(__file__).with_name("gm11_vectors.csv")
SAMPLES = ("y_km4", "y_km3", "y_km2", "y_km1", "y_k")


def vectors() -> list[dict[str, str]]:
    """Twenty windows and what GM(1,1) makes of them, 13 digits, computed with 60."""
    with VECTORS.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def samples_of(row: dict[str, str]) -> list[float]:
    return [float(row[name]) for name in SAMPLES]


def exact_fit(y: list[float]) -> tuple[Fraction, Fraction, Fraction]:
    """c, u and D of the closed form (8), in rationals; c and u are 0 where D is."""
    s = [Fraction(v) for v in y]
    sums = [sum(s[: i + 1], Fraction(0)) for i in range(len(s))]
    z = [(a + b) / 2 for a, b in pairwise(sums)]
    x, n = s[1:], len(z)
    zero = Fraction(0)
    sz, sx, szz = sum(z, zero), sum(x, zero), sum((v * v for v in z), zero)
    szx = sum((a * b for a, b in zip(z, x, strict=True)), zero)
    d = n * szz - sz * sz
    if d == 0:
        return Fraction(0), Fraction(0), Fraction(0)
    return (sz * sx - n * szx) / d, (szz * sx - sz * szx) / d, d


def decimal_of(x: Fraction) -> Decimal:
    return Decimal(x.numerator) / Decimal(x.denominator)


def exact_prediction(y: list[float], horizon: int = 1) -> float:
    """The restored sample N - 1 + h of equation (9) by difference, in 50 digits: (9) as it stands, divided by c."""
    with localcontext() as context:
        context.prec = 50
        c, u, _ = exact_fit(y)
        if c == 0:
            return float(decimal_of(u))
        k, v, first = decimal_of(c), decimal_of(u), Decimal(y[0])
        at = len(y) - 1 + horizon

        def sums(t: int) -> Decimal:
            return (first - v / k) * (-k * t).exp() + v / k

        return float(sums(at) - sums(at - 1))


def least_squares(y: list[float]) -> np.ndarray:
    """The pair c, u by equation (7), B and Y as the paper writes them."""
    sums = np.cumsum(y)
    b = np.column_stack([-0.5 * (sums[1:] + sums[:-1]), np.ones(len(y) - 1)])
    return np.linalg.lstsq(b, np.asarray(y[1:], dtype=float), rcond=None)[0]
