"""Are the results of two commits the same? ``make same BASE=<commit>``: a net for refactoring.

Every row of ``commands.toml`` runs on both commits, each from its own source tree with its own compile cache, side by
side. HEAD is the working tree as it is. What a command prints (JSON) and what it writes is flattened to
``key -> number or text`` and compared exactly. Keys that were renamed on purpose are in ``renamed.toml``, what differs
from run to run is in ``excluded.toml``.

The exit code is 0 where nothing differs, 1 where something does, 2 for bad input. Both commits run with the Python and
the libraries that run this file, also where a commit asks for others.
"""

from __future__ import annotations

import argparse
import csv
import fcntl
import hashlib
import io
import itertools
import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
import zipfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / "build" / "same"
INPUTS = {"data": "tests/corpus/0.1.0", "examples": "examples"}
"""Folders that commands read from: a name in the folder of a side, and its place in the source tree."""

SHOWN = 12
"""Differences printed for each command; ``build/same/differences.csv`` has all of them."""

TIMEOUT = 900

Value = float | int | bool | str | None
Flat = dict[str, Value]
Difference = tuple[str, str, Value, Value]


class BadInput(Exception):
    """What was asked for cannot be done."""


# ---- what is compared


def flatten(value: Any, key: str = "") -> Iterator[tuple[str, Value]]:
    """Keys and leaves of JSON. Rows of a list that have a name or key are found by it, so that rows may be added."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from flatten(part, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list):
        names = [part.get("name", part.get("key")) if isinstance(part, Mapping) else None for part in value]
        by_name = len(set(names)) == len(names) and all(isinstance(name, str) for name in names)
        if not value:
            yield f"{key}[]", 0
        for i, part in enumerate(value):
            yield from flatten(part, f"{key}[{names[i] if by_name else i}]")
    else:
        yield key, value


def of_text(text: str, cut: list[re.Pattern[str]]) -> Iterator[tuple[str, Value]]:
    """A table of numbers cell by cell, JSON leaf by leaf; of other text the SHA-256 and the number of lines."""
    if text.startswith("{"):
        try:
            yield from flatten(json.loads(text))
            return
        except ValueError:
            pass
    lines = [line for line in text.splitlines() if line and line[0] != "#"]
    head, *rows = list(csv.reader(lines)) or [[]]
    if len(head) > 1 and rows and all(len(row) == len(head) and number(row[0]) is not None for row in rows):
        for i, row in enumerate(rows):
            for name, cell in zip(head, row, strict=True):
                value = number(cell)
                yield f"{name.strip()}[{i}]", cell if value is None else value
        return
    for pattern in cut:
        text = pattern.sub("", text)
    yield "sha256", hashlib.sha256(text.encode()).hexdigest()[:16]
    yield "lines", text.count("\n")


def number(cell: str) -> float | None:
    """The number that a cell of a table holds, hexadecimal ones included."""
    try:
        return float.fromhex(cell) if "0x" in cell else float(cell)
    except ValueError:
        return None


def of_file(name: str, data: bytes, cut: list[re.Pattern[str]]) -> Iterator[tuple[str, Value]]:
    """Keys and values of a file that a command wrote."""
    if name.endswith((".fmu", ".npz")):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for member in sorted(archive.namelist()):
                for key, value in of_file(member, archive.read(member), cut):
                    yield f"{member}:{key}", value
    elif name.endswith(".toml"):
        yield from flatten(tomllib.loads(data.decode()))
    elif name.endswith(".npy"):
        table = np.load(io.BytesIO(data))
        yield from ((f"[{i}]", leaf.item()) for i, leaf in enumerate(table.ravel()))
    elif name.endswith(".parquet"):
        import pyarrow.parquet as pq  # NumPy cannot read it

        table = pq.read_table(io.BytesIO(data))
        for column in table.column_names:
            yield from ((f"{column}[{i}]", value) for i, value in enumerate(table.column(column).to_pylist()))
    else:
        try:
            yield from of_text(data.decode(), cut)
        except UnicodeDecodeError:
            yield "sha256", hashlib.sha256(data).hexdigest()[:16]


def equal(a: Value, b: Value) -> bool:
    """The same bits, the same text; 1 and 1.0 are equal, NaN is equal to NaN, True is not 1."""
    if isinstance(a, bool) or isinstance(b, bool):
        return a is b
    if isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b):
        return True
    if isinstance(a, float) and isinstance(b, float) and a == b == 0:
        return math.copysign(1, a) == math.copysign(1, b)
    return a == b


def ran(flat: Flat) -> bool:
    """Whether a command did its work: not where it was refused, was killed or took too long."""
    return flat.get("exit code") in (0, 1, 3)


def compare(base: Mapping[str, Flat], head: Mapping[str, Flat]) -> list[Difference]:
    """Every key whose values differ, command by command; a key that one side lacks has ``None`` there."""
    out: list[Difference] = []
    for command in [*head, *(c for c in base if c not in head)]:
        old, new = base.get(command, {}), head.get(command, {})
        if ran(old) != ran(new):
            old, new = ({key: side.get(key) for key in ("exit code", "message")} for side in (old, new))
        for key in [*new, *(k for k in old if k not in new)]:
            if key not in old or key not in new or not equal(old[key], new[key]):
                out.append((command, key, old.get(key, "(no such key)"), new.get(key, "(no such key)")))
    return out


def relative(a: Value, b: Value) -> str:
    """The relative difference of two numbers; empty for anything else."""
    if any(isinstance(x, bool) or not isinstance(x, int | float) for x in (a, b)):
        return ""
    return f"{abs(b - a) / max(abs(a), abs(b)):.2g}" if a != b else "0"  # type: ignore[operator, type-var, arg-type]


# ---- tables


def table(path: Path, *sections: str) -> dict[str, dict[str, str]]:
    """A TOML file of rows of text in named sections."""
    try:
        read = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise BadInput(f"{path}: {error}") from None
    for section in sections:
        rows = read.setdefault(section, {})
        if not isinstance(rows, dict) or not all(isinstance(row, str) for row in rows.values()):
            raise BadInput(f"{path}: [{section}] needs rows of the form 'name' = 'text'")
    return read


class Rules:
    """What is renamed and what is left out."""

    def __init__(self, folder: Path = HERE) -> None:
        renamed = table(folder / "renamed.toml", "words", "keys", "values")
        excluded = table(folder / "excluded.toml", "keys", "files", "text")
        self.words = renamed["words"]
        self.values = renamed["values"]
        self.keys = [(re.compile(old), new) for old, new in renamed["keys"].items()]
        self.without_keys = [re.compile(p) for p in excluded["keys"]]
        self.without_files = [re.compile(p) for p in excluded["files"]]
        self.cut = [re.compile(p, re.MULTILINE) for p in excluded["text"]]

    def kept(self, flat: Mapping[str, Flat]) -> dict[str, Flat]:
        """Results without the excluded keys, and without the excluded parts of texts."""
        return {
            command: {key: self.shortened(v) for key, v in values.items() if not self.excluded(f"{command}: {key}")}
            for command, values in flat.items()
        }

    def excluded(self, key: str) -> bool:
        return any(p.search(key) for p in self.without_keys)

    def shortened(self, value: Value) -> Value:
        if isinstance(value, str):
            for pattern in self.cut:
                value = pattern.sub("", value)
        return value

    def in_new_words(self, flat: Mapping[str, Flat]) -> dict[str, Flat]:
        """Results of the base with the keys and values that they have today."""
        out: dict[str, Flat] = {}
        for command, values in flat.items():
            rows = out.setdefault(command, {})
            for key, value in values.items():
                name = f"{command}: {key}"
                for pattern, new in self.keys:
                    name = pattern.sub(new, name)
                if isinstance(value, str):
                    value = self.values.get(value, value)
                rows[name.removeprefix(f"{command}: ")] = value
        return out

    def in_old_words(self, line: str) -> str:
        """A command of today as an older version calls it."""
        for old, new in self.words.items():
            line = re.sub(rf"(?<!\S){re.escape(new)}(?![\w-])", old, line)
        return line


# ---- a side


def git(*words: str, **env: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False, env={**os.environ, **env}
    )
    if done.returncode:
        raise BadInput(f"git {' '.join(words)}: {done.stderr.strip()}")
    return done.stdout.strip()


def tree_of(commit: str) -> str:
    """The tree of a commit."""
    try:
        return git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{commit}^{{tree}}")
    except BadInput:
        raise BadInput(f"no commit {commit!r}") from None


def working_tree() -> str:
    """The tree that a commit of everything would have: what is changed and new included, what is ignored not."""
    with tempfile.TemporaryDirectory() as folder:
        index = Path(folder) / "index"
        shutil.copy(ROOT / git("rev-parse", "--git-path", "index"), index)
        git("add", "--all", GIT_INDEX_FILE=str(index))
        return git("write-tree", GIT_INDEX_FILE=str(index))


class Side:
    """One commit: its source tree in a temporary folder, its own cache, its results."""

    def __init__(self, name: str, tree: str, rows: Mapping[str, str], rules: Rules, temporary: Path) -> None:
        self.name, self.tree, self.rules = name, tree, rules
        self.source = temporary / name
        self.folder = BUILD / name
        committed = name == "base" or tree == tree_of("HEAD")
        self.cache = BUILD / "cache" / f"{name}-{tree[:12]}" if committed else temporary / "cache"
        self.rows = rows
        self.own: dict[str, str] = {}
        self.lines: dict[str, str] = {}
        self.results: dict[str, Flat] = {}
        self.seconds: dict[str, float] = {}

    def build(self) -> None:
        """Writes the source tree, the folder that commands run in, and the files that they read."""
        archive = subprocess.run(
            ["git", "-C", str(ROOT), "archive", "--format=tar", self.tree], capture_output=True, check=True
        ).stdout
        self.source.mkdir()
        with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            tar.extractall(self.source, filter="data")
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for name, place in INPUTS.items():
            own = self.source / place
            shutil.copytree(own if own.is_dir() else ROOT / place, self.folder / name)
        own_table = self.source / HERE.relative_to(ROOT) / "commands.toml"
        own_rows = table(own_table, "quick", "whole") if own_table.is_file() else {"quick": {}, "whole": {}}
        self.own = {**own_rows["quick"], **own_rows["whole"]}

    def run(self, progress: Progress) -> Side:
        """Runs every row: as this commit's own table has it; where that is refused as today's, then in old words."""
        for name, line in self.rows.items():
            started = time.monotonic()
            for words in dict.fromkeys((self.own.get(name, line), line, self.rules.in_old_words(line))):
                self.lines[name], self.results[name] = words, self.call(words)
                if ran(self.results[name]):
                    break
            self.seconds[name] = time.monotonic() - started
            progress.done(self.name, name)
        return self

    def call(self, line: str) -> Flat:
        """What a command prints and writes, flat."""
        before = self.files()
        env = {
            **{k: v for k, v in os.environ.items() if not k.startswith("LEADSCREW_")},
            "PYTHONPATH": str(self.source / "src"),
            "PYTHONDONTWRITEBYTECODE": "",
            "LEADSCREW_CACHE_DIR": str(self.cache),
            "OPENBLAS_NUM_THREADS": "1",
            "MPLBACKEND": "Agg",
            "COLUMNS": "200",
            "NO_COLOR": "1",
        }
        try:
            done = subprocess.run(
                [sys.executable, "-m", "leadscrew", *shlex.split(line)],
                cwd=self.folder, env=env, capture_output=True, text=True, timeout=TIMEOUT, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return {"exit code": f"none after {TIMEOUT} s"}
        out: Flat = {"exit code": done.returncode}
        if not ran(out):
            out["message"] = done.stderr.strip()[-300:]
        out.update(of_text(self.without_paths(done.stdout), self.rules.cut))
        for path, state in self.files().items():
            if before.get(path) != state and not any(p.search(path) for p in self.rules.without_files):
                data = (self.folder / path).read_bytes()
                if b"\0" not in data:
                    data = self.without_paths(data.decode()).encode()
                out.update((f"{path}:{key}", value) for key, value in of_file(path, data, self.rules.cut))
        return out

    def without_paths(self, text: str) -> str:
        """A text without the folders of this side."""
        return text.replace(f"{self.folder}/", "").replace(f"{self.source}/", "")

    def files(self) -> dict[str, tuple[int, int]]:
        """Every file in the folder, with what shows that it was written again."""
        found = ((path, path.stat()) for path in sorted(self.folder.rglob("*")) if path.is_file())
        return {path.relative_to(self.folder).as_posix(): (stat.st_mtime_ns, stat.st_size) for path, stat in found}


class Progress:
    """One line on a terminal, gone at the end; nothing elsewhere."""

    def __init__(self, total: int) -> None:
        self.count, self.total = itertools.count(1), total

    def done(self, side: str, name: str) -> None:
        if sys.stderr.isatty():
            count = next(self.count)
            line = f"{count} of {self.total}: {side}: {name}" if count < self.total else ""
            print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)


# ---- the report


def report(found: list[Difference], sides: list[Side]) -> None:
    """Prints what differs, command by command, and writes all of it to ``differences.csv``."""
    build = BUILD.relative_to(ROOT)
    with (BUILD / "differences.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["command", "key", "base", "head", "relative difference"])
        writer.writerows((*row, relative(row[2], row[3])) for row in found)
    for command, group in itertools.groupby(found, key=lambda row: row[0]):
        listed = list(group)
        print(f"{command}: {len(listed)} differ")
        for line in dict.fromkeys(side.lines[command] for side in sides):
            print(f"    leadscrew {line}")
        for _, key, old, new in listed[:SHOWN]:
            share = relative(old, new)
            print(f"    {key}: base {shown(old)}, head {shown(new)}{share and f', relative difference {share}'}")
        if len(listed) > SHOWN:
            print(f"    and {len(listed) - SHOWN} more, in {build}/differences.csv")
    if found:
        print(f"files that the commands wrote: diff -r {build}/base {build}/head")
    keys = sum(len(flat) for flat in sides[1].results.values())
    print(f"{len(sides[1].rows)} commands, {keys} keys: {f'{len(found)} differ' if found else 'no difference'}")


def shown(value: Value) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= 100 else f"{text[:48]} ... {text[-48:]}"


def refused(sides: list[Side]) -> list[str]:
    """Rows that ran on no side: nothing was compared."""
    return [name for name in sides[1].rows if not any(ran(side.results[name]) for side in sides)]


def both(rows: Mapping[str, str], base: str, head: str) -> list[Side]:
    """Both sides with their results."""
    BUILD.mkdir(parents=True, exist_ok=True)
    with (BUILD / "lock").open("w") as lock, tempfile.TemporaryDirectory(prefix="leadscrew-same-") as temporary:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise BadInput(f"another comparison runs in {BUILD}") from None
        rules, progress = Rules(), Progress(2 * len(rows))
        sides = [Side(name, tree, rows, rules, Path(temporary)) for name, tree in (("base", base), ("head", head))]
        for side in sides:
            side.build()
        with ThreadPoolExecutor(2) as pool:
            return list(pool.map(lambda side: side.run(progress), sides))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", help="a commit")
    parser.add_argument("--whole", action="store_true", help="also run all five studies")
    parser.add_argument("--numbers", action="store_true", help="list no differences between texts")
    parser.add_argument("--only", default="", metavar="PATTERN", help="only rows whose name matches")
    parser.add_argument("--times", action="store_true", help="print the seconds of each command, base and head")
    options = parser.parse_args()
    started = time.monotonic()
    try:
        sections = table(HERE / "commands.toml", "quick", "whole")
        rows = {**sections["quick"], **(sections["whole"] if options.whole else {})}
        rows = {name: line for name, line in rows.items() if re.search(options.only, name)}
        if not rows:
            raise BadInput(f"no row of commands.toml matches {options.only!r}")
        sides = both(rows, tree_of(options.base), working_tree())
    except (BadInput, re.error) as error:
        print(f"same: {error}", file=sys.stderr)
        return 2
    rules = sides[1].rules
    old, new = (rules.kept(side.results) for side in sides)
    found = compare(rules.in_new_words(old), new)
    if options.numbers:
        found = [row for row in found if not all(isinstance(value, str) for value in row[2:])]
    for name in rows if options.times else ():
        print(f"{sides[0].seconds[name]:6.1f} {sides[1].seconds[name]:6.1f} s  {name}")
    for name in (nothing := refused(sides)):
        print(f"{name}: refused on both sides, nothing compared: {sides[1].results[name].get('message')}")
    report(found, sides)
    print(f"{time.monotonic() - started:.0f} s")
    return 1 if found or nothing else 0


if __name__ == "__main__":
    sys.exit(main())
