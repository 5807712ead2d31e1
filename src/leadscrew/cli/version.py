"""``leadscrew version``: what is installed."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed

import typer

from leadscrew._version import __version__
from leadscrew.cli.options import Json
from leadscrew.cli.output import deliver
from leadscrew.report.report import Lines, Report, head

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
    lines = Lines(f"{name} {text}" for name, text in found.items())
    deliver(Report({**head("version"), **found}, [lines]), as_json=as_json)
