"""The bits of a double as an int64 and back, and arrays on the stack: what the portable functions stand on.

Plain Python here; ``leadscrew.kernel.bits_numba`` gives Numba the same names as single instructions. Importing
this module imports neither NumPy nor Numba.
"""

from __future__ import annotations

import struct
from typing import Any

INTRINSICS = ("bits_to_float", "float_to_bits", "stack_array2", "stack_buffer")
"""The names that every engine supplies itself."""

_FLOAT = struct.Struct("<d")
_INT = struct.Struct("<q")


def float_to_bits(x: float) -> int:
    """The 64 bits of ``x`` as a signed integer: -2**63 to 2**63 - 1."""
    bits: int = _INT.unpack(_FLOAT.pack(x))[0]
    return bits


def bits_to_float(i: int) -> float:
    """The double whose 64 bits are those of ``i``, any int64."""
    x: float = _FLOAT.unpack(_INT.pack(i))[0]
    return x


def stack_buffer(n: int) -> Any:
    """Room for ``n`` floats (a literal); for Numba a pointer to 64-byte aligned stack memory, for ``carray``."""
    import numpy as np

    return np.empty(n)


def stack_array2(rows: int, cols: int) -> Any:
    """An array of ``rows`` x ``cols`` floats (literals), not set to anything; for Numba it lies on the stack.

    It must not outlive the call of the function in which it is made.
    """
    import numpy as np

    return np.empty((rows, cols))
