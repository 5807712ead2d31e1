"""Machine code from a lowered entry: optimised once for this processor, kept as an object file, called through ctypes.

Measured on the lathe servo (2 shared cores): Numba needs 5 to 12 s of processor time for a loop's first call and 0.5 s
for a cached one; this path well under 1 s and 0.02 s. The arithmetic is the same, so are the bits; the Numba
engine stays as an independent second compiler of the same text.
"""

from __future__ import annotations

import ast
import ctypes
import hashlib
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.kernel import cache


@lru_cache(maxsize=1)
def _binding() -> Any:
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


@lru_cache(maxsize=1)
def _machine() -> tuple[Any, str]:
    """The target machine, and what identifies it."""
    llvm = _binding()
    features = llvm.get_host_cpu_features().flatten()
    cpu = llvm.get_host_cpu_name()
    target = llvm.Target.from_default_triple()
    machine = target.create_target_machine(cpu=cpu, features=features, opt=3, reloc="default", codemodel="jitdefault")
    return machine, f"{target.triple} {cpu} {features} llvm{'.'.join(map(str, llvm.llvm_version_info))}"


@lru_cache(maxsize=1)
def _compiler() -> str:
    """What identifies the lowering itself: the hash of its source, so that its own changes are not missed."""
    folder = Path(__file__).parent
    return hashlib.sha256(b"".join((folder / f).read_bytes() for f in ("lower.py", "native.py"))).hexdigest()[:16]


def optimised(module: Any) -> Any:
    """The module after LLVM's full optimisation, vectorisers on, without any fast-math."""
    llvm = _binding()
    machine, _ = _machine()
    module.triple = machine.triple
    parsed = llvm.parse_assembly(str(module))
    parsed.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = True
    options.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(parsed, builder)
    return parsed


_alive: list[Any] = []


def _load(code: bytes, name: str) -> int:
    """The address of a function in an object file brought into this process."""
    llvm = _binding()
    machine = llvm.Target.from_default_triple().create_target_machine(opt=3, codemodel="jitdefault")
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _alive.append(engine)
    return int(engine.get_function_address(name))


def compiled(
    node: ast.FunctionDef, text: str, ranks: Mapping[str, tuple[int, str]], constants: Mapping[str, np.ndarray]
) -> Callable[..., int]:
    """An entry as a function of NumPy arrays; its machine code comes from the cache where it is there."""
    _, machine = _machine()
    key = hashlib.sha256(f"{cache.stamp()}\n{_compiler()}\n{machine}\n{text}".encode()).hexdigest()[:24]
    code = cache.read(f"loop_{key}.o")
    if code is None:
        from leadscrew.kernel.lower import Lowering

        code = _machine()[0].emit_object(optimised(Lowering(node, ranks, constants).run()))
        cache.write(f"loop_{key}.o", code)
    kinds = [
        (rank, np.dtype(np.float64 if element == "f" else np.int64))
        for rank, element in (ranks[a.arg] for a in node.args.args)
    ]
    types = [t for rank, _ in kinds for t in (ctypes.c_void_p, *[ctypes.c_int64] * rank)]
    function = ctypes.CFUNCTYPE(ctypes.c_int64, *types)(_load(code, node.name))

    def entry(*arrays: np.ndarray) -> int:
        given: list[int] = []
        for array, (rank, dtype) in zip(arrays, kinds, strict=True):
            if array.ndim != rank or array.dtype != dtype or not array.flags.c_contiguous:
                raise TypeError(f"{node.name}: expected a contiguous {dtype} array of {rank} dimensions")
            given.append(array.ctypes.data)
            given.extend(array.shape)
        return int(function(*given))

    return entry
