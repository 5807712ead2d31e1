"""The engines: an entry of a generated module, run by each of them with the same bits.

``llvm``: our own lowering, optimised once for this processor, kept as an object file, called through ctypes. Measured
on the lathe servo (2 shared cores): well under 1 s of processor time for a loop's first call, 0.02 s for a cached one.
``c``: a C compiler, where the machine has one, makes a shared library that is kept in the cache.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from leadscrew.kernel import cache
from leadscrew.kernel.trees import treework
from leadscrew.util.errors import EngineError, ValueRefused
from leadscrew.util.frames import warning_level

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module


ENGINES = ("llvm", "c", "python")
"""The engines, the fastest to start first."""


def check_engine(engine: str) -> None:
    """Refuses what is no engine.

    Raises:
        ValueRefused: names the ones there are.
    """
    if engine not in ENGINES:
        raise ValueRefused(f"engine = {engine!r}: there are {', '.join(ENGINES)}")


def without_numba(engine: Any) -> Any:
    """The engine that a file names; ``llvm`` in place of ``numba``, which version 0.1.0 had, with a warning."""
    if engine != "numba":
        return engine
    text = "engine = 'numba': this engine was removed; 'llvm' runs instead and gives the same bits"
    warnings.warn(text, stacklevel=warning_level())
    return "llvm"


def native(module: Module, name: str, engine: str, title: str, ranks: Mapping[str, tuple[int, str]]) -> Entry:
    """An entry as machine code: from our own lowering, or from C and the machine's compiler; kept in the cache.

    ``title`` identifies the module and the entry there, ``ranks`` says what arrays the entry takes.

    Raises:
        EngineError: the engine ``c`` without a C compiler.
    """
    return (by_c if engine == "c" else by_llvm)(module, name, title, ranks)


def by_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of the module's own text; overflow and the like give infinity and NaN, and no warning."""

    def quiet(*args: Any) -> Any:
        with np.errstate(all="ignore"):
            return function(*args)

    return quiet


# ---- llvm
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
def by_llvm(module: Module, name: str, title: str, ranks: Mapping[str, tuple[int, str]]) -> Entry:
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


# ---- c
C_FLAGS = ("-std=c99", "-march=native", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fwrapv")
"""None of these changes a result: contraction is off, the other three say what the code never looks at or relies on."""
C_LEVELS = {"single": "-O2"}
"""A single run has nothing to vectorise: -O3 is no faster there, and takes longer to compile. Else -O3."""


@lru_cache(maxsize=1)
def c_compiler() -> str:
    """The C compiler: the one that ``CC`` names, else cc, gcc or clang.

    Raises:
        EngineError: there is none.
    """
    named = shlex.split(os.environ.get("CC", ""))
    for name in [*named[:1], "gcc", "clang", "cc"]:
        found = shutil.which(name)
        if found:
            return found
    said = f"CC={named[0]} is not there, and neither are" if named else "there is no C compiler:"
    raise EngineError(f"{said} gcc, clang, cc on the PATH; install gcc, or use engine='llvm', which needs none")


@lru_cache(maxsize=1)
def _identity() -> str:
    """What compiled code depends on, besides its source: the compiler file, the processor, the printer."""
    path = Path(c_compiler()).resolve()
    stat = path.stat()
    flags = ""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        flags = next((x for x in lines if x.startswith(("flags", "Features"))), "")
    except OSError:
        flags = platform.processor()
    stamp = (str(path), str(stat.st_size), str(stat.st_mtime_ns))
    parts = (cache.sources(), *stamp, platform.machine(), flags, str(C_FLAGS), str(C_LEVELS))
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:12]


def shared_library(source: str, folder: Path, name: str, *flags: str) -> Path:
    """A shared library from C source, in a folder.

    Raises:
        EngineError: the compiler refuses it; its first complaint is in the text.
    """
    file = folder / f"{name}.c"
    file.write_text(source, encoding="utf-8", newline="\n")
    made = folder / f"{name}.so"
    command = [
        c_compiler(),
        *(flags or (*C_FLAGS, C_LEVELS.get(name, "-O3"))),
        "-fPIC",
        "-shared",
        "-o",
        str(made),
        str(file),
        "-lm",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        said = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip()[:300])
        raise EngineError(f"{c_compiler()} does not compile {name}.c: {said}")
    return made


@treework()
def by_c(module: Module, name: str, title: str, ranks: Mapping[str, tuple[int, str]]) -> Entry:
    """An entry of a module, compiled from C; the library comes from the cache where it is there.

    Raises:
        EngineError: there is no compiler, or it refuses the source.
    """
    file = f"{title}_{_identity()}.so"
    if cache.read(file) is not None:
        library = ctypes.CDLL(str(cache.directory() / file))
    else:
        from leadscrew.kernel.c99.translation import entry_text

        with tempfile.TemporaryDirectory(prefix="leadscrew-", ignore_cleanup_errors=True) as folder:
            made = shared_library(entry_text(module, name, ranks), Path(folder), name)
            kept = cache.write(file, made.read_bytes())
            library = ctypes.CDLL(str(cache.directory() / file if kept else made))
    address = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
    assert address is not None
    return Entry(name, [ranks[a] for a in module.arguments_of(name)], address)
