"""Work on trees: they may be deep, and hold no cycles.

Python stops recursion at 1,000 calls, which a sum of 250 terms needs; and half of a compilation went into looking for
cycles.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from leadscrew.kernel.errors import SubsetError

DEEPEST = 20_000
"""Calls in one another."""


@contextmanager
def treework() -> Iterator[None]:
    """Inside it, or in a function that it decorates, recursion may go deep, and the garbage collector waits.

    Raises:
        SubsetError: an expression lies too deep all the same.
    """
    collects, calls = gc.isenabled(), sys.getrecursionlimit()
    gc.disable()
    sys.setrecursionlimit(max(calls, DEEPEST))
    try:
        yield
    except RecursionError:
        raise SubsetError(
            "an expression is nested too deep to be compiled, or a function calls itself: divide it into statements"
        ) from None
    finally:
        sys.setrecursionlimit(calls)
        if collects:
            gc.enable()
