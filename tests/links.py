"""What one file leads to: the files that it imports or names, and the tables that lead on by a name.

Used by :mod:`tests.closure`.
"""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import PurePath
from textwrap import dedent
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tests.closure import Tree

WHOLE = {"blocks": "BLOCKS", "block_names": "BLOCKS", "factories": "FACTORIES", "study_names": "STUDIES"}
"""Functions that go through a whole table of the catalogue."""
WORD, DOTTED = re.compile(r"[\w.*-]*\w"), re.compile(r"\b(?:leadscrew|tests)(?:\.\w+)+")
TARGET = re.compile(r"(leadscrew(?:\.\w+)+):(\w+)")
PROGRAM = re.compile(r"\bleadscrew +([a-z][\w-]*)(?: +([a-z][\w-]*))?")
PAGES = "*.md"
FIRST = re.compile(r"(?:^|\")\s*([a-z][\w-]*)(?: +([a-z][\w-]*))?", re.MULTILINE)
IMPORT = re.compile(r"\bfrom ((?:leadscrew|tests)[\w.]*) import \(?([\w, \n]+)")
STUDY = re.compile(r"src/leadscrew/studies/\w+/study\.py")
"""The file of a study."""
EVALUATES, MAY = "src/leadscrew/studies/results.py", re.compile("tests/|src/leadscrew/cli/|src/leadscrew/panel/")
"""The module that evaluates a study, and where one who imports it does so."""


@dataclass
class Links:
    """What a file leads to."""

    edges: set[str] = field(default_factory=set)
    words: set[str] = field(default_factory=set)
    """Words of its strings: names of the catalogue, perhaps."""
    commands: set[str] = field(default_factory=set)
    """The first two words of its strings and of their lines: commands, perhaps."""
    taken: set[tuple[str, str]] = field(default_factory=set)
    """Names taken from other files."""
    tables: dict[str, dict[str, str]] = field(default_factory=dict)
    """The file of each key, table by table."""
    lists: dict[str, set[str]] = field(default_factory=dict)
    """Files that a global name of a test helper stands for: who takes that name reads them."""


def walk(tree: ast.AST) -> defaultdict[type, list[Any]]:
    """The nodes by type, without docstrings and what is for type checkers only."""
    kinds: defaultdict[type, list[Any]] = defaultdict(list)
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        kinds[type(node)].append(node)
        for name in node._fields:
            value = getattr(node, name, None)
            for child in value if isinstance(value, list) else (value,):
                if not isinstance(child, ast.AST) or isinstance(child, ast.expr_context | ast.operator):
                    continue
                docstring = isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)
                if not docstring and not (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)):
                    waiting.append(child)
    return kinds


def strings(node: ast.AST | None) -> dict[str, str]:
    """The rows of a dictionary that holds nothing but strings."""
    pairs = zip(node.keys, node.values, strict=True) if isinstance(node, ast.Dict) else ()
    rows = {k.value: v.value for k, v in pairs if isinstance(k, ast.Constant) and isinstance(v, ast.Constant)}
    texts = all(isinstance(x, str) for pair in rows.items() for x in pair)
    return rows if texts and isinstance(node, ast.Dict) and len(rows) == len(node.keys) else {}  # type: ignore[return-value]


class Scan:
    """Finds what one file leads to."""

    def __init__(self, tree: Tree, file: str) -> None:
        self.tree, self.file, self.links, self.bound = tree, file, Links(), dict[str, str]()
        self.library = file.endswith(".py") and file.startswith(("src/", "docs/"))

    def module(self, name: str) -> bool:
        """Adds a module; False where there is none of that name."""
        self.links.edges |= {self.tree.module(name)} - {""}
        return bool(self.tree.module(name))

    def name(self, module: str, name: str, taken: bool = True) -> None:
        """Adds what defines a name of a module; ``*`` is all names of a lazy package."""
        exports = self.tree.exports(module)
        for own in exports if name == "*" else {name} & exports.keys():
            self.name(exports[own], own)
        if name in exports or not self.module(f"{module}.{name}"):
            self.module(module)
            self.links.taken |= {(self.tree.module(module), WHOLE.get(name, name))} if taken else set()

    def path(self, dotted: str, taken: bool = True) -> None:
        """Adds what ``package.module.name`` leads to."""
        module, *names = dotted.split(".")
        for name in names:
            if name in self.tree.exports(module) or not self.tree.module(f"{module}.{name}"):
                return self.name(module, name, taken)
            module = f"{module}.{name}"
        self.module(module)

    def text(self, text: str, python: bool = False, home: str = "") -> None:
        """Adds what a string, or a file, leads to."""
        if python or "import leadscrew" in text or IMPORT.search(text):
            try:
                return self.code(ast.parse(dedent(text)))
            except SyntaxError:
                pass
        for module, names in IMPORT.findall(text):
            for name in WORD.findall(names):
                self.name(module, name)
        for dotted in DOTTED.findall(text):
            self.path(dotted)
        if not self.library:
            words = set(WORD.findall(text))
            self.links.words |= {w.strip("-.") for w in words}
            named = {f for w in words & self.tree.named.keys() for f in self.tree.named[w]}
            if words & {".md", PAGES}:
                named |= {f for f in self.tree.files if f.endswith(".md") and f.count("/") <= 1}
            (self.links.lists.setdefault(home, set()) if home else self.links.edges).update(named)
            typed = PROGRAM.findall(text)
            self.links.commands |= {w for words in (*typed, *FIRST.findall(text)) for w in words}
            self.links.edges |= {self.tree.module("leadscrew.__main__")} - {""} if typed else set()

    def code(self, tree: ast.Module) -> None:
        """Adds what Python code leads to."""
        kinds = walk(tree)
        for imported in (*kinds[ast.Import], *kinds[ast.ImportFrom]):
            self.imported(imported)
        loops = [n.iter for n in (*kinds[ast.For], *kinds[ast.comprehension])]
        gone_through = {id(n) for loop in loops for n in ast.walk(loop)}
        bases = {id(n.value) for n in kinds[ast.Attribute]}
        skipped = {id(v) for n in (*kinds[ast.Assign], *kinds[ast.AnnAssign]) for v in self.table(n)}
        lists = {
            id(value): ast.unparse(node.targets[0])
            for node in tree.body
            if isinstance(node, ast.Assign) and self.file not in self.tree.tests and PAGES in ast.unparse(node)
            for value in ast.walk(node)
        }
        for node in kinds[ast.Attribute]:
            if dotted := self.dotted(node):
                self.path(dotted, not self.library or (self.file.startswith("src/") and id(node) in gone_through))
        for node in kinds[ast.Name]:
            if node.id in self.bound and id(node) not in bases:
                self.name(self.bound[node.id], "*")
        for node in kinds[ast.Constant]:
            if isinstance(node.value, str) and id(node) not in skipped:
                self.text(node.value, home=lists.get(id(node), ""))
        constants = {node.value for node in kinds[ast.Constant] if isinstance(node.value, str)}
        if {"-m", "leadscrew"} <= constants and not self.library:
            self.module("leadscrew.__main__")
        for node in kinds[ast.JoinedStr]:
            self.template([v.value if isinstance(v, ast.Constant) else None for v in node.values])
        for node in kinds[ast.Call]:
            self.call(node)

    def dotted(self, node: ast.AST) -> str:
        """The full name of an expression such as ``module.name``, where its first name is a module of ours."""
        if isinstance(node, ast.Name):
            return self.bound.get(node.id, "")
        base = self.dotted(node.value) if isinstance(node, ast.Attribute) else ""
        return f"{base}.{node.attr}" if base and isinstance(node, ast.Attribute) else ""

    def imported(self, node: ast.Import | ast.ImportFrom) -> None:
        """Adds what an import leads to, and binds its names to modules."""
        for a in node.names:
            if isinstance(node, ast.Import):
                self.path(a.name)
                own, full = (a.asname, a.name) if a.asname else (a.name.split(".")[0],) * 2
            else:
                here = self.file.removeprefix("src/").removesuffix(".py").split("/")[: -node.level or None]
                base = ".".join([*(here if node.level else ()), *filter(None, [node.module])])
                self.name(base, a.name)
                own, full = a.asname or a.name, "" if a.name in self.tree.exports(base) else f"{base}.{a.name}"
            if self.tree.module(full):
                self.bound[own] = full

    def table(self, node: ast.Assign | ast.AnnAssign) -> list[ast.expr]:
        """Keeps a table of strings; gives the strings that lead nowhere by themselves."""
        rows = {k: TARGET.fullmatch(v) for k, v in strings(node.value).items()}
        if not rows or not all(rows.values()) or not isinstance(node.value, ast.Dict):
            return []
        homes = {k: (m[1], self.tree.exports(m[1]).get(m[2], m[1])) for k, m in rows.items() if m}
        name = ast.unparse(node.target if isinstance(node, ast.AnnAssign) else node.targets[0])
        self.links.tables[name] = {k: self.tree.module(home) for k, (_, home) in homes.items()}
        return node.value.values

    def template(self, parts: list[object]) -> None:
        """Adds the modules whose name is put together: all of the package that it begins with.

        Those of a study are claims, experiments and figures: only who evaluates it needs them.
        """
        if STUDY.fullmatch(self.file):
            return
        if isinstance(parts[0], str) and DOTTED.fullmatch(package := parts[0].rstrip(".")) and parts[0].endswith("."):
            folder = PurePath(self.tree.module(package) or f"src/{package.replace('.', '/')}/__init__.py").parent
            self.links.edges |= {f for f in self.tree.files if f.endswith(".py") and PurePath(f).parent == folder}

    def call(self, node: ast.Call) -> None:
        """Keeps commands that are put into a typer app, and names that the library looks up in the catalogue."""
        key: ast.expr | None = next((k.value for k in node.keywords if k.arg == "name"), None)
        function = node.func.func if isinstance(node.func, ast.Call) else node.func
        if isinstance(node.func, ast.Call) and node.func.args:
            key = node.func.args[0]
        kind = getattr(function, "attr", getattr(function, "id", ""))
        if kind in ("command", "add_typer") and node.args and isinstance(key, ast.Constant):
            module = self.dotted(node.args[0]).rpartition(".")[0]
            if self.tree.module(module):
                self.links.tables.setdefault("commands", {})[str(key.value)] = self.tree.module(module)
        if kind in ("study", "block") and node.args and isinstance(node.args[0], ast.Constant):
            self.links.words.add(str(node.args[0].value))
