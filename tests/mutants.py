"""Changes one operator, number or condition of the library at a time, and prints each change that no test notices.

    python -m tests.mutants [--base COMMIT] [--max N] [--seed N] [--seconds S] [FILE...]

Without a FILE: the files of ``src`` that have changed since the base. Each mutant runs in a copy of the working tree,
never in the tree itself, against the tests that can reach its file (:mod:`tests.closure`), the nearest first, as many
as pass in ``--seconds``. Exit code 0 when it ran, whatever survived; 2 for bad input.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePath

from tests.closure import ROOT, Tree, changes, git

OPTIONS = ("-x", "-q", "-m", "not slow", "-p", "no:cacheprovider")
GRACE_S, SLOWER = 15.0, 3.0
"""A mutant may take this many seconds more than this many times what the tests take without it."""


@dataclass(frozen=True)
class Mutant:
    """One change of a file."""

    file: str
    line: int
    operator: str
    before: str
    after: str

    @property
    def diff(self) -> str:
        """The changed lines."""
        lines = difflib.unified_diff(self.before.splitlines(), self.after.splitlines(), lineterm="", n=0)
        return "\n".join(f"    {line}" for line in list(lines)[2:] if not line.startswith("@@"))


def mutants_of(file: str, code: str, seed: int) -> Iterator[Mutant]:
    """Mutants of a file in random order: each place once, with a random change, before any place is changed again."""
    from cosmic_ray import plugins
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.mutating import mutate_code

    places: dict[tuple[int, int], list[tuple[str, int]]] = {}
    nodes = list(ast_nodes(get_ast(code)))
    for name in plugins.operator_names():
        with suppress(TypeError):  # operators that need a variable
            positions = [p for node in nodes for p in plugins.get_operator(name)().mutation_positions(node)]
            for occurrence, (start, _) in enumerate(positions):
                places.setdefault(start, []).append((name, occurrence))
    draw = random.Random(f"{seed} {file}")
    places_in_turn = [(start, draw.sample(edits, len(edits))) for start, edits in sorted(places.items())]
    draw.shuffle(places_in_turn)
    for turn in range(max((len(edits) for _, edits in places_in_turn), default=0)):
        for (line, _), edits in places_in_turn:
            if turn < len(edits):
                name, occurrence = edits[turn]
                after = mutate_code(code, plugins.get_operator(name)(), occurrence)
                if after is not None and differs(code, after):
                    yield Mutant(file, line, name.removeprefix("core/"), code, after)


def differs(before: str, after: str) -> bool:
    """False where only annotations of functions differ, which nothing evaluates, or the mutant is no Python."""
    try:
        return plain(before) != plain(after)
    except SyntaxError:
        return False


def plain(code: str) -> str:
    """The code without the annotations of functions."""
    tree = ast.parse(code)
    for node in ast.walk(tree):
        if isinstance(node, ast.arg):
            node.annotation = None
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            node.returns = None
    return ast.dump(tree)


def nearest_first(file: str, tests: list[str]) -> list[str]:
    """Tests named after the file, then those of its folder, then of folders above it."""
    parts, stem = PurePath(file).parts[2:-1], PurePath(file).stem

    def far(test: str) -> tuple[bool, int, str]:
        own = PurePath(test).parts[1:-1]
        shared = next(
            (i for i, (a, b) in enumerate(zip(parts, own, strict=False)) if a != b), min(len(parts), len(own))
        )
        return f"test_{stem}" not in PurePath(test).stem, -shared, test

    return sorted(tests, key=far)


class Copy:
    """A copy of the working tree in which tests run."""

    def __init__(self, root: Path, folder: Path) -> None:
        self.root, self.tree, self.written = root, folder / "tree", 0
        for name in git(root, "ls-files", "--cached", "--others", "--exclude-standard"):
            if (root / name).is_file():
                (self.tree / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(root / name, self.tree / name)
        self.environment = os.environ | {
            "PYTHONPATH": str(self.tree / "src"), "HOME": str(folder), "CI": "true", "PYTHONHASHSEED": "0",
            "LEADSCREW_CACHE_DIR": str(root / "build" / "mutants_cache"),
        }  # fmt: skip
        self.durations: dict[str, float | None] = {}

    def write(self, file: str, code: str) -> None:
        """Writes a file, with a time of its own: Python must not take its byte code from the cache."""
        self.written += 2
        (self.tree / file).write_text(code, encoding="utf-8")
        os.utime(self.tree / file, (self.written, self.written))

    def run(self, tests: list[str], limit_s: float) -> int | None:
        """The exit code of pytest; None where it took too long."""
        command = [sys.executable, "-m", "pytest", *OPTIONS, *tests]
        process = subprocess.Popen(
            command, cwd=self.tree, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        try:
            return process.wait(limit_s)
        except subprocess.TimeoutExpired:
            return None
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def baseline(self, tests: list[str], seconds: float) -> tuple[list[str], float]:
        """The tests that pass unchanged, in this order, up to so many seconds; and what they take."""
        passing: list[str] = []
        total = 0.0
        for test in tests:
            if test not in self.durations:
                began = time.monotonic()
                code = self.run([test], seconds + GRACE_S)
                self.durations[test] = time.monotonic() - began if code == 0 else None
            duration = self.durations[test]
            if duration is not None and total + duration <= seconds:
                passing.append(test)
                total += duration
            if total > 0.8 * seconds:
                break
        return passing, total


def outcomes(copy: Copy, mutants: list[Mutant], tests: list[str], duration: float) -> Counter[str]:
    """Runs the tests with each mutant, prints who survives, and counts."""
    counts: Counter[str] = Counter()
    for mutant in mutants:
        copy.write(mutant.file, mutant.after)
        code = copy.run(tests, SLOWER * duration + GRACE_S)
        copy.write(mutant.file, mutant.before)
        counts["timed out" if code is None else "killed" if code else "survived"] += 1
        if code == 0:
            print(f"survived {mutant.file}:{mutant.line} ({mutant.operator})\n{mutant.diff}", flush=True)
    return counts


def main(arguments: list[str] | None = None, root: Path = ROOT) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description="Changes that no test notices.")
    parser.add_argument("files", nargs="*", metavar="FILE", help="of src; those that changed since the base if none")
    parser.add_argument("--base", metavar="COMMIT", help="origin/main, or HEAD~1 where there is none")
    parser.add_argument("--max", type=int, default=30, help="number of mutants (30)")
    parser.add_argument("--seed", type=int, default=1, help="another number draws other mutants (1)")
    parser.add_argument("--seconds", type=float, default=30.0, help="what the tests of one mutant may take (30)")
    options = parser.parse_args(arguments)
    try:
        files = options.files or changed(root, options.base)
    except (OSError, subprocess.CalledProcessError):
        parser.error(f"git does not know the commit {options.base or 'HEAD~1'}")
    for file in files:
        if not (file.startswith("src/") and file.endswith(".py") and (root / file).is_file()):
            parser.error(f"{file} is not a Python file of src")
    if options.max < 1 or not options.seconds > 0:
        parser.error("--max and --seconds must be positive")
    codes = {file: (root / file).read_text(encoding="utf-8") for file in files}
    if not codes:
        print("no Python file of src has changed")
    tree = Tree(root)
    reach = {test: tree.closure(test) for test in tree.tests}
    with tempfile.TemporaryDirectory(prefix="leadscrew-mutants-", ignore_cleanup_errors=True) as folder:
        copy = Copy(root, Path(folder))
        for i, (file, code) in enumerate(codes.items()):
            share = options.max // len(codes) + (i < options.max % len(codes))
            mutants = [m for m, _ in zip(mutants_of(file, code, options.seed), range(share), strict=False)]
            tests = nearest_first(file, [test for test in tree.tests if file in reach[test]])
            chosen, duration = copy.baseline(tests, options.seconds) if mutants else ([], 0.0)
            print(
                f"{file}: {len(mutants)} mutants, {len(chosen)} of {len(tests)} test files, {duration:.0f} s:",
                flush=True,
            )
            print("".join(f"    {test}\n" for test in chosen), end="", flush=True)
            if chosen:
                counts = outcomes(copy, mutants, chosen, duration)
                print(", ".join(f"{counts[what]} {what}" for what in ("killed", "timed out", "survived")), flush=True)
            elif mutants:
                print("no test file that reaches it passes in that time: nothing was tried")
    return 0


def changed(root: Path, base: str | None) -> list[str]:
    """The Python files of src that differ from a commit; raises where git does not know it."""
    if base is None:
        known = git(root, "for-each-ref", "refs/remotes/origin/main")
        base = "origin/main" if known else "HEAD~1"
    files = sorted({*changes(root, base)})
    return [f for f in files if f.startswith("src/") and f.endswith(".py") and (root / f).is_file()]


if __name__ == "__main__":
    sys.exit(main())
