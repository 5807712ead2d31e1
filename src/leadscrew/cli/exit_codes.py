"""Exit codes, and where an error becomes one sentence, one JSON object with ``--json``, and one of them."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import shutil
import sys
import textwrap
import traceback
import warnings
from collections.abc import Iterator
from typing import Any

import typer
from typer.core import TyperGroup

from leadscrew.util.errors import Diverged, LeadscrewError
from leadscrew.util.escape import one_line
from leadscrew.util.frames import origin

MISSED, REFUSED, DIVERGED, INTERNAL, INTERRUPTED, PIPE_CLOSED = 1, 2, 3, 70, 130, 141
"""Exit codes: a target missed, bad input, a loop diverged, a fault of ours, Ctrl-C, the reader of a pipe gone."""


class Door(TyperGroup):
    """The group of commands.

    What they raise on purpose leaves here as one sentence on stderr; with ``--json`` there is one object on stdout too,
    as after a success: ``kind``, ``schema_version``, ``error`` and ``exit_code``.
    """

    as_json = False

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Looks for ``--json``, which the command itself reads later."""
        self.as_json = "--json" in (args[: args.index("--")] if "--" in args else args)
        with self._usage():
            return super().parse_args(ctx, args)

    @contextlib.contextmanager
    def _usage(self) -> Iterator[None]:
        """Says in JSON what click says of a wrong command line."""
        try:
            yield
        except Exception as error:
            if _of_usage(error):
                self._object(error.format_message(), error.exit_code)  # type: ignore[attr-defined]
            raise

    def _object(self, why: str, code: int) -> None:
        if self.as_json:
            found = {"schema_version": 1, "kind": "leadscrew error", "error": one_line(why), "exit_code": code}
            typer.echo(json.dumps(found))

    def invoke(self, ctx: Any) -> Any:
        """Runs the command."""
        with warnings.catch_warnings():
            warnings.showwarning = _one_line  # type: ignore[assignment]
            try:
                with self._usage():
                    return super().invoke(ctx)
            except KeyboardInterrupt:
                raise typer.Exit(INTERRUPTED) from None
            except Exception as error:
                if isinstance(error, OSError) and error.errno == errno.EPIPE:
                    to_nowhere(sys.stdout)
                    raise typer.Exit(PIPE_CLOSED) from None
                if _of_usage(error) or isinstance(error, typer.Exit | typer.Abort):
                    raise
                why = _sentence(error)
                if not why:
                    self._object(f"a fault of Leadscrew: {type(error).__name__}: {error}", INTERNAL)
                    raise
                if ctx.params.get("debug"):
                    traceback.print_exc()
                code = DIVERGED if isinstance(error, Diverged) else REFUSED
                self._object(why, code)
                say(f"leadscrew: {why}")
                raise typer.Exit(code) from None


def _of_usage(error: Exception) -> bool:
    """Whether it is one of click's, which later versions of typer bring along."""
    return hasattr(error, "format_message")


def _sentence(error: Exception) -> str:
    """An error raised on purpose, what a file asks for that no computer can do, or where code of the user failed; empty
    for a fault of ours.
    """
    why = one_line(str(error))
    if isinstance(error, LeadscrewError):
        return why
    if isinstance(error, MemoryError):
        return f"there is not enough memory for this: ask for less ({why or 'no more is known'})"
    if type(error).__name__ == "LinAlgError":
        return f"the numbers have no solution: are columns and units right? ({why})"
    at = origin(error)
    return f"{at}: {type(error).__name__}: {why}" if at else ""


def say(text: str) -> None:
    """One line on stderr; in a terminal as many as it takes, broken between words."""
    if sys.stderr.isatty():
        columns = shutil.get_terminal_size().columns
        text = textwrap.fill(text, columns, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)
    typer.echo(text, err=True)


def _one_line(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: Any) -> None:
    say(f"warning: {one_line(str(message))}")


def to_nowhere(stream: Any) -> None:
    """Nobody reads this stream any more; what is left in it goes to the null device."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
