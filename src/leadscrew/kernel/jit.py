"""What a generated module takes from Numba: two decorators and the primitives that are single instructions."""

from numba import njit

from leadscrew.kernel.bits import stack_array2, stack_buffer
from leadscrew.kernel.bits_numba import bits_to_float, float_to_bits, ieee_select

leaf = njit(error_model="numpy", forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""A step or what it calls: always inlined into an entry."""
entry = njit(error_model="numpy", nogil=True, cache=True, no_cfunc_wrapper=True)
"""What Python calls: flat arrays in and out, without the interpreter lock, cached on disk."""

__all__ = ["bits_to_float", "entry", "float_to_bits", "leaf", "ieee_select", "stack_array2", "stack_buffer"]
