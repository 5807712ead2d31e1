"""The command line: one row a command, imported when it is called.

It adds nothing that the library lacks. Exit codes: 0 well, 1 a number that is not the expected one (or a replay that is
not identical), 2 bad input, 3 a loop diverged, 130 interrupted.
"""

from __future__ import annotations

import gc
import os
import sys
import traceback
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import Annotated, Any

import typer

from leadscrew.cli.exit_codes import INTERNAL, INTERRUPTED, PIPE_CLOSED, Door, to_nowhere
from leadscrew.cli.terminal import Guarded
from leadscrew.cli.version import print_and_exit
from leadscrew.util.frames import DEBUG
from leadscrew.util.reading import VARIABLE, factor

__all__ = ["app", "main"]

COMMANDS = {
    "demo": "leadscrew.cli.demo:demo",
    "list": "leadscrew.cli.listing:list_",
    "run": "leadscrew.cli.run:run",
    "simulate": "leadscrew.cli.simulate:simulate",
    "export": "leadscrew.cli.export:export",
    "verify-export": "leadscrew.cli.export:verify_export",
    "replay": "leadscrew.cli.replay:replay",
    "diff": "leadscrew.cli.diff:diff",
    "tune": "leadscrew.cli.tune:tune",
    "compare": "leadscrew.cli.compare:compare",
    "montecarlo": "leadscrew.cli.montecarlo:montecarlo",
    "certify": "leadscrew.cli.certify:certify",
    "positioning": "leadscrew.cli.positioning:positioning",
    "ballbar": "leadscrew.cli.ballbar:ballbar",
    "harmonics": "leadscrew.cli.harmonics:harmonics",
    "excite": "leadscrew.cli.excite:excite",
    "following-error": "leadscrew.cli.following_error:following_error",
    "frequency-response": "leadscrew.cli.frequency_response:frequency_response",
    "predict": "leadscrew.cli.predict:predict",
    "fuzzy": "leadscrew.cli.fuzzy:app",
    "design": "leadscrew.cli.design:app",
    "log": "leadscrew.cli.log:log",
    "identify": "leadscrew.cli.identify:app",
    "tangent": "leadscrew.cli.tangent:app",
    "panel": "leadscrew.cli.panel:panel",
    "bench": "leadscrew.cli.bench:bench",
    "cache": "leadscrew.cli.cache:app",
    "version": "leadscrew.cli.version:version",
}
"""Each command and where it is: a module, and the function or the group of commands in it."""


class Commands(Door):
    """The commands of :data:`COMMANDS`; a module is imported, and its options are read, when a command needs them."""

    def __init__(self, **more: Any) -> None:
        super().__init__(**more)
        self.commands = LazyCommands()  # type: ignore[assignment]

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Takes ``--debug`` wherever it stands before a ``--``."""
        end = args.index("--") if "--" in args else len(args)
        if "--debug" in args[:end]:
            args = ["--debug", *(a for a in args[:end] if a != "--debug"), *args[end:]]
        return super().parse_args(ctx, args)


class LazyCommands(Mapping[str, Any]):
    """Each command by its name, built on first use."""

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
    found = getattr(import_module(module), attribute)
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
    debug: Annotated[bool, typer.Option("--debug", envvar=DEBUG, help="Show the traceback of an error.")] = False,
    file_limits: Annotated[
        float | None,
        typer.Option(
            metavar="FACTOR",
            help="Multiply the limits on the size of files that are read, and on time and memory.",
            envvar=VARIABLE,
        ),
    ] = None,
    show_version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=print_and_exit, is_eager=True),
    ] = False,
) -> None:
    """A workbench for intelligent control of machine-tool axes and cutting processes."""
    if debug:
        os.environ[DEBUG] = "1"
    if file_limits is not None:
        os.environ[VARIABLE] = str(file_limits)
        factor()


def main() -> None:
    """The entry point of the program."""
    code: str | int | None = 0
    gc.set_threshold(20_000, 20, 50)  # syntax trees are many small objects, none of them in a cycle
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    sys.stdout = Guarded(sys.stdout)
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
    gc.freeze()  # else Python looks for cycles among all objects as it ends: 1.5 s after a whole study
    sys.exit(code)
