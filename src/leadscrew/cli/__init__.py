"""The command line: one row a command, imported when it is called.

It adds nothing that the library lacks. Exit codes: 0 well, 1 a
required target missed (or a replay that is not identical), 2 bad input, 3 a loop diverged, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import Annotated, Any

import typer

from leadscrew.cli.door import INTERNAL, INTERRUPTED, PIPE_CLOSED, Door, to_nowhere
from leadscrew.cli.version import print_and_exit

__all__ = ["app", "main"]

COMMANDS = {
    "demo": "demo:demo",
    "list": "listing:list_",
    "run": "run:run",
    "simulate": "simulate:simulate",
    "export": "export:export",
    "verify-export": "export:verify_export",
    "replay": "replay:replay",
    "diff": "diff:diff",
    "tune": "tune:tune",
    "compare": "compare:compare",
    "montecarlo": "montecarlo:montecarlo",
    "certify": "certify:certify",
    "positioning": "positioning:positioning",
    "ballbar": "ballbar:ballbar",
    "harmonics": "harmonics:harmonics",
    "excite": "excite:excite",
    "following-error": "following_error:following_error",
    "frequency-response": "frequency_response:frequency_response",
    "predict": "predict:predict",
    "fuzzy": "fuzzy:app",
    "design": "design:app",
    "log": "log:log",
    "identify": "identify:app",
    "tangent": "tangent:app",
    "panel": "panel:panel",
    "bench": "bench:bench",
    "cache": "cache:app",
    "version": "version:version",
}
"""Each command and where it is: the module in this package, and the function or the group of commands in it."""


class Commands(Door):
    """The commands of :data:`COMMANDS`; a module is imported, and its options are read, when a command needs them."""

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        self.commands = Made()  # type: ignore[assignment]


class Made(Mapping[str, Any]):
    """Each command by its name, made when it is asked for."""

    def __getitem__(self, name: str) -> Any:
        if name not in COMMANDS:
            raise KeyError(name)
        return _command(name)

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


@cache
def _command(name: str) -> Any:
    module, attribute = COMMANDS[name].split(":")
    found = getattr(import_module(f"leadscrew.cli.{module}"), attribute)
    if not isinstance(found, typer.Typer):
        alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
        alone.command(name)(found)
        found = alone
    command = typer.main.get_command(found)
    command.name = name
    return command


app = typer.Typer(
    name="leadscrew",
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _leadscrew(
    debug: Annotated[
        bool, typer.Option("--debug", envvar="LEADSCREW_DEBUG", help="Show the traceback of an error.")
    ] = False,
    show_version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=print_and_exit, is_eager=True),
    ] = False,
) -> None:
    """A workbench for intelligent control of machine-tool axes and cutting processes."""


def main() -> None:
    """The entry point of the program."""
    code: str | int | None = 0
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        app(prog_name="leadscrew")
    except SystemExit as stop:
        code = stop.code
    except KeyboardInterrupt:
        code = INTERRUPTED
    except BrokenPipeError:
        code = PIPE_CLOSED
    except Exception:
        traceback.print_exc()
        code = INTERNAL
    try:
        sys.stdout.flush()
    except OSError:
        to_nowhere(sys.stdout)
        code = code or PIPE_CLOSED
    if code == INTERRUPTED and os.name == "posix":
        # Worker threads of a batch must not hold up a Ctrl-C.
        sys.stderr.flush()
        os._exit(INTERRUPTED)
    sys.exit(code)
