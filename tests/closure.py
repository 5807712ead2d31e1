"""The test files that a set of changed files can affect: by imports, names of the catalogue, commands and files read.

    python -m tests.closure FILE...           the test files that reach one of these files
    python -m tests.closure --base COMMIT     those for the changes since that commit, uncommitted ones included

An edge leads from a file to each file that it imports (also in functions, in strings of code, in the Python of a page)
or names. A name of a lazy package leads to the file that defines it. Tables of strings (``{"sine":
"leadscrew.references._sine:sine"}``) and typer's commands lead to those entries whose key is in a string of the test.
"""

from __future__ import annotations

import argparse
import ast
import re
import subprocess
from collections.abc import Iterable
from fnmatch import fnmatch
from functools import cache, cached_property
from pathlib import Path, PurePath

from tests.links import EVALUATES, MAY, STUDY, Links, Scan

ROOT = Path(__file__).parents[1]
EVERYTHING = ("pyproject.toml", "constraints.txt", "tests/conftest.py")
"""Changes that affect every test."""
FOLDERS = ("src", "tests", "docs", "examples", "peers", ".ci")
GENERATED = re.compile(r"__pycache__|/_build/|/generated/")
FENCE = re.compile(r"^```(\S*).*?\n(.*?)^```", re.MULTILINE | re.DOTALL)


class Tree:
    """The files below a root, and what each leads to."""

    def __init__(self, root: Path) -> None:
        paths = [p for p in (*root.iterdir(), *(p for f in FOLDERS for p in (root / f).rglob("*"))) if p.is_file()]
        self.files = {name for p in paths if not GENERATED.search(name := p.relative_to(root).as_posix())}
        self.tests = sorted(f for f in self.files if f.startswith("tests/") and fnmatch(Path(f).name, "test_*.py"))
        self.named: dict[str, set[str]] = {}
        """Files that are read by their name: all but packages, test files and the library's modules."""
        for f in self.files.difference(self.tests):
            if not f.endswith("/__init__.py") and not (f.startswith("src/") and f.endswith(".py")):
                self.named.setdefault(Path(f).name, set()).add(f)
        self.root, self.links = root, cache(self._links)
        self.module, self.exports = cache(self._module), cache(self._exports)
        self.next = cache(self._next)

    def _module(self, name: str) -> str:
        base = ("" if name.startswith("tests") else "src/") + name.replace(".", "/")
        return next((f for f in (f"{base}/__init__.py", f"{base}.py") if f in self.files), "")

    def _exports(self, package: str) -> dict[str, str]:
        """The module of each public name of a lazy package."""
        stub = f"{self.module(package)}i"
        if stub not in self.files:
            return {}
        body = ast.parse((self.root / stub).read_text(encoding="utf-8")).body
        return {
            alias.name: f"{package}.{node.module}"
            for node in body
            if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module
            for alias in node.names
        }

    def _links(self, file: str) -> Links:
        scan = Scan(self, file)
        if file.endswith((".py", ".md", ".toml", ".txt", ".ipynb", ".hal", ".ini")):
            text = (self.root / file).read_text(encoding="utf-8", errors="replace")
            for language, body in FENCE.findall(text) if file.endswith(".md") else [(file.rpartition(".")[2], text)]:
                scan.text(body, python=language in ("py", "python"))
        scan.links.edges -= {file, *scan.links.tables.get("commands", {}).values()}
        return scan.links

    def _next(self, file: str) -> set[str]:
        """Where a file leads whoever reaches it: imports, files that it names, the packages that hold it."""
        return {*self.links(file).edges, *(f"{p}/__init__.py" for p in PurePath(file).parents)} & self.files

    def judging(self, file: str) -> set[str]:
        """Where the file of a study leads who evaluates it: to all of its folder."""
        folder = file.rpartition("/")[0]
        return {f for f in self.files if STUDY.fullmatch(file) and f.startswith(f"{folder}/") and f.endswith(".py")}

    @cached_property
    def shared(self) -> set[str]:
        """The Python that every test reaches: of ``tests/conftest.py`` and its plug-ins, without what they name."""
        new, reached = {"tests/conftest.py"} & self.files, set[str]()
        while new:
            reached |= new
            new = {f for file in new for f in self.next(file) if f.endswith(".py")} - reached
        return reached

    def closure(self, test: str) -> set[str]:
        """All files that a test reaches."""
        new = {test, *(f"{folder}/conftest.py" for folder in PurePath(test).parents[:-2])} & self.files
        reached, entered, taken = set[str](), set[str](), set[tuple[str, str]]()
        words, commands = set[str](), set[str]()
        while new:
            while new:
                reached |= new
                links = [self.links(f) for f in new]
                entered = entered.union(*(x.edges for x in links))
                words = words.union(*(x.words for x in links))
                commands = commands.union(*(x.commands for x in links))
                taken = taken.union(*(x.taken for x in links))
                new = set[str]().union(*map(self.next, new)) - reached
            judges = any(EVALUATES in self.links(f).edges and MAY.match(f) for f in reached)
            for file in reached:  # last, when all words are known
                new |= self.judging(file) if judges else set()
                new |= {f for name, listed in self.links(file).lists.items() if (file, name) in taken for f in listed}
                for name, table in self.links(file).tables.items():
                    typed = name.lower() == "commands"
                    keys = (commands if typed else words) & table.keys()
                    if (file, name) in taken or (typed and file in entered and not keys):
                        keys = set(table)
                    new |= {table[k] for k in keys}
            entered |= new
            new = new & self.files - reached
        return reached | self.shared

    def affected(self, changed: Iterable[str]) -> list[str]:
        """The test files that can notice a change of these files (paths from the root)."""
        reach = {test: self.closure(test) for test in self.tests}
        aims: set[str] = set()
        for file in changed:
            if any(fnmatch(file, pattern) for pattern in EVERYTHING):
                return self.tests
            aims.add(file)
            folders = [
                p for p in Path(file).parents if any(f.startswith(f"{p}/") and f.endswith(".py") for f in self.files)
            ]
            if file.startswith("src/") and (file not in self.files or not file.endswith(".py")):
                aims |= {next((f for p in folders if (f := f"{p}/__init__.py") in self.files), "")}
            elif file.startswith("tests/") and file not in self.tests and not any(file in f for f in reach.values()):
                aims |= {f for f in self.files if folders and f.startswith(f"{folders[0]}/")}
        return [test for test in self.tests if reach[test] & aims]


def git(root: Path, *args: str) -> list[str]:
    """The lines that git prints; raises CalledProcessError, or OSError where there is no git."""
    return subprocess.run(["git", *args], cwd=root, capture_output=True, text=True, check=True).stdout.splitlines()


def changes(root: Path, commit: str) -> list[str]:
    """The files that differ from a commit, uncommitted and new ones included; raises like :func:`git`."""
    differing = git(root, "diff", "--name-only", "--no-renames", "--relative", commit, "--")
    return [*differing, *git(root, "ls-files", "--others", "--exclude-standard")]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.closure", description="Test files that changes can affect.")
    parser.add_argument("files", nargs="*", metavar="FILE")
    parser.add_argument("--base", metavar="COMMIT", help="Add the files that have changed since this commit.")
    options = parser.parse_args()
    for test in Tree(ROOT).affected([*options.files, *(changes(ROOT, options.base) if options.base else [])]):
        print(test)
