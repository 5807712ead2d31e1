"""``leadscrew version``: what is installed."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed

import typer

from leadscrew._version import __version__
from leadscrew.cli.output import Json, emit

SHOWN = ("llvmlite", "numpy", "scipy")


def print_and_exit(wanted: bool) -> None:
    """Behind ``--version``."""
    if wanted:
        typer.echo(f"leadscrew {__version__}")
        raise typer.Exit


def version(as_json: Json = False) -> None:
    """Print the version of Leadscrew and of what its results depend on."""
    found = {"leadscrew": __version__, "python": platform.python_version()}
    for name in SHOWN:
        try:
            found[name] = installed(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    if as_json:
        emit(found)
        return
    for name, text in found.items():
        typer.echo(f"{name} {text}")
