"""``leadscrew cache``: the compiled modules that are kept."""

from __future__ import annotations

import typer

from leadscrew.cli.options import Json
from leadscrew.cli.output import deliver
from leadscrew.report.report import Report, head

app = typer.Typer(help="The compiled modules that are kept between sessions.", no_args_is_help=True)


@app.command("info")
def info(as_json: Json = False) -> None:
    """Where the cache lies and how much is in it."""
    from leadscrew.kernel import cache

    found = cache.info()
    said = f"{found.folder}: {found.modules} compiled modules, {found.bytes / 1e6:.1f} MB"
    deliver(Report({**head("cache info"), **found.__dict__}, [said]), as_json=as_json)


@app.command("clear")
def clear(as_json: Json = False) -> None:
    """Delete the compiled modules; they are made again when needed."""
    from leadscrew.kernel import cache

    before = cache.clear()
    after = cache.info()
    removed = {"folder": before.folder, "modules": before.modules - after.modules, "bytes": before.bytes - after.bytes}
    said = f"{before.folder}: removed {removed['modules']} compiled modules, {before.bytes / 1e6:.1f} MB"
    deliver(Report({**head("cache clear"), **removed}, [said]), as_json=as_json)
