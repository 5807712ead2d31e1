"""Functions that were normalised before, for the next module that holds them.

Most functions of a loop (drivers, portable mathematics, fuzzy steps, metrics) stand in many loops, and normalise to the
same tree wherever the module gives the same answers: the same names for what they call, the same constants and types.
A tree is kept with the questions of its normaliser and the answers; the questions are put to another module, which adds
on the way what is called, and the tree serves it if all answers are the same.
"""

from __future__ import annotations

import ast
import threading
import types
from collections import OrderedDict
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from leadscrew.kernel.subset import NUMBERS
from leadscrew.kernel.trees import copied, fingerprint

if TYPE_CHECKING:
    from leadscrew.kernel.module import Module

LIMIT = 1024
"""Functions that are kept."""
VARIANTS = 8
"""Trees of one function that are kept, for modules with other answers."""


class Question(NamedTuple):
    """A method of the module, what it was given, and what it answered."""

    method: str
    given: tuple[Any, ...]
    answer: Any


class Tree(NamedTuple):
    """A normalised function, before anything is noted on its nodes."""

    node: ast.FunctionDef
    print: str
    filename: str
    function: Callable[..., Any]
    source: list[Any]
    questions: list[Question]


def source_of(function: Any) -> list[Any]:
    """What decides the tree of a function, and what others read of it."""
    return [function.__code__, function.__defaults__] if isinstance(function, types.FunctionType) else []


def same(now: Any, then: Any) -> bool:
    """Whether two values of a name are the same, numbers to the last bit."""
    return now is then or (type(now) is type(then) and isinstance(now, (*NUMBERS, str)) and repr(now) == repr(then))


def _answer(module: Module, method: str, given: tuple[Any, ...]) -> list[Any]:
    """An answer, and what the normaliser reads from what it is given."""
    return [getattr(module, method)(*given), *source_of(given[0])]


class Recorder:
    """A module for one normaliser: hands its questions on, and remembers each with its answer."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.questions: dict[tuple[Any, ...], Question] = {}

    def __getattr__(self, method: str) -> Callable[..., Any]:
        def ask(*given: Any) -> Any:
            answer = _answer(self.module, method, given)
            key = (method, *(g if isinstance(g, str | bool | int) else id(g) for g in given))
            self.questions.setdefault(key, Question(method, given, answer))
            return answer[0]

        return ask


def _same(now: list[Any], then: list[Any]) -> bool:
    return len(now) == len(then) and all(map(same, now, then))


class Trees:
    """The trees of this process, those that were asked for last."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[int, bool, str], list[Tree]] = OrderedDict()
        self._lock = threading.Lock()

    def found(self, module: Module, function: Callable[..., Any], trusted: bool, name: str) -> Tree | None:
        """A tree that serves a module as a function of that name; what the function calls is then in the module."""
        with self._lock:
            kept = list(self._kept.get((id(function), trusted, name), ()))
        for tree in kept:
            if _same(source_of(function), tree.source) and all(
                _same(_answer(module, q.method, q.given), q.answer) for q in tree.questions
            ):
                return tree
        return None

    def add(
        self, node: ast.FunctionDef, filename: str, trusted: bool, function: Callable[..., Any], recorder: Recorder
    ) -> Tree:
        """Keeps a copy of a tree that was made by such a recorder."""
        tree = Tree(
            copied(node), fingerprint(node), filename, function, source_of(function), list(recorder.questions.values())
        )
        with self._lock:
            kept = self._kept.setdefault((id(function), trusted, node.name), [])
            kept[:] = [tree, *kept[: VARIANTS - 1]]
            self._kept.move_to_end((id(function), trusted, node.name))
            while len(self._kept) > LIMIT:
                self._kept.popitem(last=False)
        return tree

    def clear(self) -> None:
        """Forgets all of them."""
        with self._lock:
            self._kept.clear()


trees = Trees()
