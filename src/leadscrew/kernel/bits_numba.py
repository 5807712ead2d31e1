"""Gives Numba the functions of ``leadscrew.kernel.bits``: bit casts, and arrays on the stack."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import carray, types
from numba.extending import intrinsic, overload

from leadscrew.kernel import bits


@intrinsic
def float_to_bits(typing_context: Any, x: Any) -> Any:
    """The bits of a float, for generated modules."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def bits_to_float(typing_context: Any, i: Any) -> Any:
    """The float of some bits, for generated modules."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], ir.DoubleType())

    return types.float64(types.int64), generate


@intrinsic(prefer_literal=True)
def _stack_pointer(typing_context: Any, n: Any) -> Any:
    if not isinstance(n, types.IntegerLiteral):
        return None
    size = n.literal_value

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        # In the entry block: an alloca inside a loop would grow the stack at every pass.
        with builder.goto_entry_block():
            room = builder.alloca(ir.ArrayType(ir.DoubleType(), size))
            room.align = 64
        return builder.bitcast(room, ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(n), generate


@intrinsic
def ieee_select(typing_context: Any, condition: Any, yes: Any, no: Any) -> Any:
    """``yes if condition else no`` without a branch; both are computed."""
    kind = typing_context.unify_types(yes, no)

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(args[0], args[1], args[2])

    return kind(types.boolean, kind, kind), generate


# ---- for functions that are compiled on their own, outside a generated module
@overload(bits.float_to_bits, inline="never")
def _float_to_bits(x):
    if isinstance(x, (types.Float, types.Integer, types.Boolean)):
        return lambda x: float_to_bits(float(x))  # type: ignore[call-arg]
    return None


@overload(bits.bits_to_float, inline="never")
def _bits_to_float(i):
    if isinstance(i, types.Integer):
        return lambda i: bits_to_float(i)  # type: ignore[call-arg]
    return None


# Stack memory lives as long as the frame that holds it, so both are inlined into their caller before it is compiled.
@overload(bits.stack_buffer, inline="always", prefer_literal=True)
def _stack_buffer(n):
    if isinstance(n, types.IntegerLiteral):
        return lambda n: _stack_pointer(n)  # type: ignore[call-arg]
    return None


@overload(bits.stack_array2, inline="always", prefer_literal=True)
def _stack_array2(rows, cols):
    if not (isinstance(rows, types.IntegerLiteral) and isinstance(cols, types.IntegerLiteral)):
        return None
    shape = (rows.literal_value, cols.literal_value)
    size = shape[0] * shape[1]

    def array(rows, cols):
        return carray(_stack_pointer(size), shape)  # type: ignore[call-arg]

    return array
