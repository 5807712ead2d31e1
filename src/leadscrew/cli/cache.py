"""``leadscrew cache``: the compiled modules that are kept."""

from __future__ import annotations

import typer

from leadscrew.cli.output import Json, emit

app = typer.Typer(help="The compiled modules that are kept between sessions.", no_args_is_help=True)


@app.command("info")
def info(as_json: Json = False) -> None:
    """Where the cache lies and how much is in it."""
    from leadscrew.kernel import cache

    found = cache.info()
    if as_json:
        emit(found.__dict__)
        return
    typer.echo(f"{found.folder}: {found.modules} compiled modules, {found.bytes / 1e6:.1f} MB")


@app.command("clear")
def clear(as_json: Json = False) -> None:
    """Delete the compiled modules; they are made again when needed."""
    from leadscrew.kernel import cache

    before = cache.clear()
    after = cache.info()
    removed = {"folder": before.folder, "modules": before.modules - after.modules, "bytes": before.bytes - after.bytes}
    if as_json:
        emit(removed)
        return
    typer.echo(f"{removed['folder']}: removed {removed['modules']} compiled modules, {before.bytes / 1e6:.1f} MB")
