"""Random programs, the same bits on every engine: plain Python, machine code, C fused and as it is exported.

    python -m tests.kernel.differential --programs 2000 --first 0

prints every program that differs, and ends with 1 where one does. A program is a step of :mod:`tests.kernel.generated`,
played over every pair of twenty special numbers.
"""

import argparse
import ctypes
import importlib.util
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.export.single import replay
from leadscrew.kernel.c99.translation import entry_text
from leadscrew.kernel.engines import C_FLAGS, Entry, by_llvm, shared_library
from leadscrew.kernel.trees import treework
from tests.kernel import printed
from tests.kernel.generated import module_of, module_text
from tests.kernel.printed import rows, same

RANKS = {"F": (2, "f"), "G": (2, "f")}
TOGETHER = 10
"""Programs that are compiled at once."""


def loaded(seed: int, count: int, folder: Path) -> tuple[Any, list[Any]]:
    """A module of random steps, imported; and the steps."""
    file = folder / f"generated_{seed}.py"
    file.write_text(module_text(seed, count))
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None and spec.loader is not None
    sys.modules[file.stem] = found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found, [getattr(found, f"step_{i}") for i in range(count)]


def fused(found: Any, steps: list[Any], folder: Path, engines: Sequence[str]) -> Iterator[tuple[str, np.ndarray]]:
    """What all steps give side by side in one entry, by engine."""
    module = module_of(steps, found.P, found.S)
    module.entry(found.drive, "drive")
    for engine in engines:
        if engine == "llvm":
            entry = by_llvm(module, "drive", f"random_{module.identity()}", RANKS)
        else:
            whole = engine == "c"
            text = entry_text(module, "drive", RANKS, fused=whole)
            flags = C_FLAGS if whole else (*printed.STRICT, "-O2")
            library = shared_library(text, folder, f"drive_{whole}", *flags)
            address = ctypes.cast(ctypes.CDLL(str(library)).drive, ctypes.c_void_p).value
            assert address is not None
            entry = Entry("drive", [RANKS[a] for a in module.arguments_of("drive")], address)
        got = np.full((len(rows(2)), len(steps)), -5.0)
        entry(rows(2), got)
        yield engine, got


@treework()
def differences(
    seed: int, count: int, folder: Path, levels: Sequence[str] = ("-O2",), reals: Sequence[str] = ("double",),
    engines: Sequence[str] = ("llvm", "c", "c unfused"),
) -> list[str]:  # fmt: skip
    """Where random programs differ from plain Python; empty where none does."""
    found, steps = loaded(seed, count, folder)
    given, lost, results = rows(2), [], {}
    for real in reals:
        sources = [printed.source_of(step, found.P(), found.S(), name=f"{real[0]}{i}", real=real)
                   for i, step in enumerate(steps)]  # fmt: skip
        want = [printed.by_python(s, given) if real == "double" else replay(s, given) for s in sources]
        results[real] = np.hstack([w[:, :1] for w in want])
        files = printed.written(sources, folder / real)
        for level in levels:
            library = printed.library(files, level)
            lost += [f"seed {seed}, step_{i}: exported C, {real}, {level}" for i, source in enumerate(sources)
                     if not same(printed.played(library, source, given), want[i])]  # fmt: skip
    plain = results["double"]
    assert np.isfinite(plain).mean() > 0.2, f"seed {seed}: hardly a finite number, nothing is compared"
    for engine, got in fused(found, steps, folder, engines):
        wrong = [i for i in range(count) if not same(got[:, i].copy(), plain[:, i].copy())]
        lost += [f"seed {seed}, step_{i}: {engine}" for i in wrong]
    return lost


def main() -> int:
    """The command; 1 where a program differs."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--programs", type=int, default=200)
    asked.add_argument("--first", type=int, default=0, help="seed of the first ten programs")
    words = asked.parse_args()
    lost: list[str] = []
    batches = -(-words.programs // TOGETHER)
    for n in range(batches):
        with tempfile.TemporaryDirectory() as folder:
            new = differences(words.first + n, TOGETHER, Path(folder))
        lost += new
        print(*new, f"{TOGETHER * (n + 1)} programs, {len(lost)} differences", sep="\n", flush=True)
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main())
