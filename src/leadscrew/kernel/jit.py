"""What a generated module takes from Numba: a decorator and the primitives that are single instructions."""

from numba import njit

from leadscrew.kernel.bits import stack_array2
from leadscrew.kernel.bits_numba import bits_to_float, float_to_bits, ieee_select

entry = njit(error_model="numpy", nogil=True, cache=True, no_cfunc_wrapper=True)  # type: ignore[call-overload]
"""What Python calls: flat arrays in and out, without the interpreter lock, cached on disk."""

__all__ = ["bits_to_float", "entry", "float_to_bits", "ieee_select", "stack_array2"]
