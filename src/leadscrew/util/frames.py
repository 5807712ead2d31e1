"""Tracebacks of what a user does wrong: the user's own frames, not those of this library.

A public function or class is decorated with :func:`entry_point`. An error that Leadscrew raises on purpose leaves it
without the frames of this package and of the standard library; frames of the user's own code stay. The environment
variable :data:`DEBUG` keeps all frames.
"""

from __future__ import annotations

import functools
import os
import re
import sys
import types
from typing import Any

DEBUG = "LEADSCREW_DEBUG"
"""Set to 1, it keeps the frames of this package; read whenever an error is raised."""

_UNKNOWN = re.compile(r"unexpected keyword argument '(\w+)'")
_SPECIAL = ("__init__", "__call__", "__getitem__", "__getattr__")


def debugging() -> bool:
    """Whether all frames are to be shown."""
    return os.environ.get(DEBUG, "").lower() not in ("", "0", "f", "false", "n", "no", "off")


def _is_library(frame: types.FrameType) -> bool:
    root = str(frame.f_globals.get("__name__", "")).partition(".")[0]
    return root == "leadscrew" or root in sys.stdlib_module_names


def _users(trace: types.TracebackType | None) -> types.TracebackType | None:
    """A traceback without the frames of this package and of the standard library."""
    kept = []
    while trace is not None:
        if not _is_library(trace.tb_frame):
            kept.append(trace)
        trace = trace.tb_next
    for entry in reversed(kept):
        trace = types.TracebackType(trace, entry.tb_frame, entry.tb_lasti, entry.tb_lineno)
    return trace


def _explained(function: Any, error: TypeError) -> None:
    """Adds to an error of a call what its arguments are called."""
    import difflib
    import inspect

    text = str(error)
    unknown = _UNKNOWN.search(text)
    arguments = [p for p in inspect.signature(function).parameters.values() if p.name != "self"]
    names = [p.name for p in arguments if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    if unknown is not None:
        near = difflib.get_close_matches(unknown[1], names, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(names)}"
        error.args = (f"{text[: unknown.end()]}; {hint}",)  # without the guess of Python 3.13
    elif all(p.kind is p.KEYWORD_ONLY for p in arguments) and "positional argument" in text:
        error.args = (f"{text}; name them: {', '.join(f'{n}=...' for n in names[:3])}",)


def trimmed(function: Any, *kinds: type[Exception]) -> Any:
    """A function whose errors of these kinds, and of a call with wrong arguments, show the user's frames only."""

    @functools.wraps(function)
    def entry(*args: Any, **options: Any) -> Any:
        # A bare `raise` adds no frame, so that this one goes too.
        try:
            return function(*args, **options)
        except kinds as error:
            if not debugging():
                error.__traceback__, error.__cause__ = _users(error.__traceback__), None
            raise
        except TypeError as error:
            trace = error.__traceback__
            if trace is not None and trace.tb_next is None:  # raised by the call itself
                _explained(function, error)
                if not debugging():
                    error.__traceback__ = None
            raise

    return entry


def trimmed_class(cls: type, *kinds: type[Exception]) -> None:
    """Trims the public methods and properties of a class, in place."""
    plain = "__dataclass_fields__" in vars(cls) and not hasattr(cls, "__post_init__")
    for name, member in list(vars(cls).items()):
        if (name.startswith("_") and name not in _SPECIAL) or (plain and name == "__init__"):
            continue
        if isinstance(member, types.FunctionType):
            more = (AttributeError,) if name == "__getattr__" else ()
            setattr(cls, name, trimmed(member, *kinds, *more))
        elif isinstance(member, staticmethod | classmethod):
            setattr(cls, name, type(member)(trimmed(member.__func__, *kinds)))
        elif isinstance(member, property) and member.fset is None:
            setattr(cls, name, property(trimmed(member.fget, *kinds)))
        elif isinstance(member, functools.cached_property):
            member.func = trimmed(member.func, *kinds)


def place(filename: str, line: int) -> str:
    """File and line as the user knows them: relative to the working folder, or the cell of a notebook."""
    from pathlib import Path

    shell = sys.modules.get("IPython")
    shell = shell and shell.get_ipython()
    cell = shell and shell.compile.format_code_name(filename)
    if cell:
        return f"{' '.join(cell)}:{line}"
    return f"{filename.removeprefix(f'{Path.cwd()}{os.sep}')}:{line}"


def origin(error: BaseException) -> str:
    """The last line of the user's own code, not of an installed package, that an error came through; else empty."""
    trace, last = _users(error.__traceback__), ""
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if not file.startswith("<") and "site-packages" not in file:
            last = place(file, trace.tb_lineno)
        trace = trace.tb_next
    return last


def warning_level() -> int:
    """The ``stacklevel`` with which a warning names the first caller outside this package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and _is_library(frame):
        frame, level = frame.f_back, level + 1
    return level
