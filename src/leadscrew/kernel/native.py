"""Machine code from a lowered entry: optimised once for this processor, kept as an object file, called through ctypes.

Measured on the lathe servo (2 shared cores): well under 1 s of processor time for a loop's first call, 0.02 s for a
cached one.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import cache
from leadscrew.kernel.trees import treework

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module


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


@treework()
def compiled(module: Module, name: str, title: str, ranks: Mapping[str, tuple[int, str]]) -> Entry:
    """An entry of a module as a function of NumPy arrays; its machine code comes from the cache where it is there.

    ``title`` identifies the module and the entry; the entry is fused and lowered only if the code is not in the cache.
    """
    target, machine = _machine()
    mark = hashlib.sha256(f"{cache.sources()}\n{machine}".encode()).hexdigest()[:12]
    file = f"{title}_{mark}.o"
    code = cache.read(file)
    if code is None:
        from leadscrew.kernel.lower import Lowering

        code = target.emit_object(optimised(Lowering(module.fused(name), ranks, module.arrays()).run()))
        cache.write(file, code)
    return Entry(name, [ranks[a] for a in module.arguments_of(name)], _load(code, name))


class Entry:
    """Machine code as a function of NumPy arrays. Binding it to arrays once makes a call ten times cheaper."""

    def __init__(self, name: str, order: list[tuple[int, str]], address: int) -> None:
        self.name = name
        self.kinds = [(rank, np.dtype(np.float64 if element == "f" else np.int64)) for rank, element in order]
        types = [t for rank, _ in self.kinds for t in (ctypes.c_void_p, *[ctypes.c_int64] * rank)]
        self.types = types
        self.function = ctypes.CFUNCTYPE(ctypes.c_int64, *types)(address)

    def bind(self, *arrays: np.ndarray) -> Callable[[], int]:
        """A call of the entry with these arrays, which it keeps alive.

        Raises:
            TypeError: an array that is not contiguous, or of another type or number of dimensions.
        """
        given: list[int] = []
        for array, (rank, dtype) in zip(arrays, self.kinds, strict=True):
            if array.ndim != rank or array.dtype != dtype or not array.flags.c_contiguous:
                raise TypeError(f"{self.name}: expected a contiguous {dtype} array of {rank} dimensions")
            given.append(array.ctypes.data)
            given.extend(array.shape)
        values = tuple(kind(value) for kind, value in zip(self.types, given, strict=True))
        function = self.function

        def call(_kept: tuple[np.ndarray, ...] = arrays) -> int:
            return int(function(*values))

        return call

    def __call__(self, *arrays: np.ndarray) -> int:
        return self.bind(*arrays)()
