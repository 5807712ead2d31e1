"""Array access with one meaning on every engine: a read outside gives NaN, a write outside poisons the array.

A read gives a float, from a table of whole numbers too.

The loop then finds a value that is not finite and reports divergence in the same period everywhere, where plain
Python would raise IndexError and compiled code would read what lies beside the array. ``i + 0`` makes a number of a
truth value, by which NumPy would choose other things.
"""

from collections.abc import Callable
from typing import Any

import numpy as np


def unguarded(function: Callable[..., Any]) -> Callable[..., Any]:
    """Marks a step whose indices lie inside their arrays by construction: its reads and writes get no guard.

    For code that is written by a program from the very shapes that it reads, as that of a fuzzy system is. A wrong
    index in such a step reads or writes foreign memory.
    """
    function.__dict__["unguarded"] = True
    return function


def at1(a, i):
    """``a[i]``, NaN where ``i`` is outside."""
    j = 0 if i < 0 else a.shape[0] - 1 if i >= a.shape[0] else i + 0
    value = 1.0 * a[j]
    return value if i == j else np.nan


def at2(a, i, j):
    """``a[i, j]``, NaN where an index is outside."""
    k = 0 if i < 0 else a.shape[0] - 1 if i >= a.shape[0] else i + 0
    m = 0 if j < 0 else a.shape[1] - 1 if j >= a.shape[1] else j + 0
    value = 1.0 * a[k, m]
    return value if (i == k) & (j == m) else np.nan


def put1(a, i, value):
    """``a[i] = value``; where ``i`` is outside, the nearest element becomes NaN."""
    j = 0 if i < 0 else a.shape[0] - 1 if i >= a.shape[0] else i + 0
    a[j] = value if i == j else np.nan
    return 0


def put2(a, i, j, value):
    """``a[i, j] = value``; where an index is outside, the nearest element becomes NaN."""
    k = 0 if i < 0 else a.shape[0] - 1 if i >= a.shape[0] else i + 0
    m = 0 if j < 0 else a.shape[1] - 1 if j >= a.shape[1] else j + 0
    a[k, m] = value if (i == k) & (j == m) else np.nan
    return 0
