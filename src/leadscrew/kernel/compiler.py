"""A C compiler, where the machine has one: finds it, and makes shared libraries that are kept in the cache."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from leadscrew.kernel import cache
from leadscrew.kernel.errors import EngineError
from leadscrew.kernel.native import Entry
from leadscrew.kernel.trees import treework

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module

FLAGS = ("-std=c99", "-march=native", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fwrapv")
"""None of these changes a result: contraction is off, the other three say what the code never looks at or relies on."""
LEVELS = {"single": "-O2"}
"""A single run has nothing to vectorise: -O3 is no faster there, and takes longer to compile. Else -O3."""


@lru_cache(maxsize=1)
def find() -> str:
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
    path = Path(find()).resolve()
    stat = path.stat()
    flags = ""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        flags = next((x for x in lines if x.startswith(("flags", "Features"))), "")
    except OSError:
        flags = platform.processor()
    stamp = (str(path), str(stat.st_size), str(stat.st_mtime_ns))
    parts = (cache.sources(), *stamp, platform.machine(), flags, str(FLAGS), str(LEVELS))
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:12]


def build(source: str, folder: Path, name: str, *flags: str) -> Path:
    """A shared library from C source, in a folder.

    Raises:
        EngineError: the compiler refuses it; its first complaint is in the text.
    """
    file = folder / f"{name}.c"
    file.write_text(source, encoding="utf-8", newline="\n")
    made = folder / f"{name}.so"
    done = subprocess.run(
        [find(), *(flags or (*FLAGS, LEVELS.get(name, "-O3"))), "-fPIC", "-shared", "-o", str(made), str(file), "-lm"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        said = next((x for x in done.stderr.splitlines() if "error" in x), done.stderr.strip()[:300])
        raise EngineError(f"{find()} does not compile {name}.c: {said}")
    return made


@treework()
def compiled(module: Module, name: str, title: str, ranks: Mapping[str, tuple[int, str]]) -> Entry:
    """An entry of a module, compiled from C; the library comes from the cache where it is there.

    Raises:
        EngineError: there is no compiler, or it refuses the source.
    """
    file = f"{title}_{_identity()}.so"
    if cache.read(file) is not None:
        library = ctypes.CDLL(str(cache.directory() / file))
    else:
        from leadscrew.kernel.c99.entry import entry_text

        with tempfile.TemporaryDirectory(prefix="leadscrew-", ignore_cleanup_errors=True) as folder:
            made = build(entry_text(module, name, ranks), Path(folder), name)
            kept = cache.write(file, made.read_bytes())
            library = ctypes.CDLL(str(cache.directory() / file if kept else made))
    address = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
    assert address is not None
    return Entry(name, [ranks[a] for a in module.arguments_of(name)], address)
