"""The two decorators of a generated module on the Numba engine."""

from numba import njit

import leadscrew.kernel.bits_numba  # noqa: F401

leaf = njit(error_model="numpy", forceinline=True)
"""A step or what it calls: always inlined into an entry."""
entry = njit(error_model="numpy", nogil=True, cache=True)
"""What Python calls: flat arrays in and out, without the interpreter lock, cached on disk."""
