"""The command line: ``leadscrew list | run | simulate | export | verify-export | replay | tune | compare | ...``.

It adds nothing that the library lacks, and imports nothing heavy before a command needs it. Exit codes: 0 well, 1 a
required target missed (or a replay that is not identical), 2 bad input, 3 a loop diverged, 130 interrupted.
"""

from __future__ import annotations

import os
import sys
import traceback
from typing import Annotated

import typer

from leadscrew.cli import (
    ballbar,
    bench,
    cache,
    certify,
    compare,
    demo,
    design,
    diff,
    excite,
    export,
    following_error,
    frequency_response,
    fuzzy,
    harmonics,
    identify,
    listing,
    log,
    montecarlo,
    panel,
    positioning,
    predict,
    replay,
    run,
    simulate,
    tangent,
    tune,
    version,
)
from leadscrew.cli.door import INTERNAL, INTERRUPTED, PIPE_CLOSED, Door, to_nowhere

__all__ = ["app", "main"]

app = typer.Typer(
    name="leadscrew",
    cls=Door,
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
        typer.Option("--version", help="Print the version and exit.", callback=version.print_and_exit, is_eager=True),
    ] = False,
) -> None:
    """A workbench for intelligent control of machine-tool axes and cutting processes."""


app.command("demo")(demo.demo)
app.command("list")(listing.list_)
app.command("run")(run.run)
app.command("simulate")(simulate.simulate)
app.command("export")(export.export)
app.command("verify-export")(export.verify_export)
app.command("replay")(replay.replay)
app.command("diff")(diff.diff)
app.command("tune")(tune.tune)
app.command("compare")(compare.compare)
app.command("montecarlo")(montecarlo.montecarlo)
app.command("certify")(certify.certify)
app.command("positioning")(positioning.positioning)
app.command("ballbar")(ballbar.ballbar)
app.command("harmonics")(harmonics.harmonics)
app.command("excite")(excite.excite)
app.command("following-error")(following_error.following_error)
app.command("frequency-response")(frequency_response.frequency_response)
app.command("predict")(predict.predict)
app.add_typer(fuzzy.app, name="fuzzy")
app.add_typer(design.app, name="design")
app.command("log")(log.log)
app.add_typer(identify.app, name="identify")
app.add_typer(tangent.app, name="tangent")
app.command("panel")(panel.panel)
app.command("bench")(bench.bench)
app.add_typer(cache.app, name="cache")
app.command("version")(version.version)


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
