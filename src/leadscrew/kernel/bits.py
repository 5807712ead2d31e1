"""The bits of a double as an int64 and back, and arrays on the stack: what the portable functions stand on.

Plain Python here; the compiled engines have instructions for them. Importing this module does not import NumPy.
"""

from __future__ import annotations

import struct
from typing import Any

INTRINSICS = ("bits_to_float", "float_to_bits", "stack_array2")
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


def stack_array2(rows: int, cols: int) -> Any:
    """An array of ``rows`` x ``cols`` floats (literals), not set to anything; compiled, it lies on the stack.

    It must not outlive the call of the function in which it is made.
    """
    import numpy as np

    return np.empty((rows, cols))
