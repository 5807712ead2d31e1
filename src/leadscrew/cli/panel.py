"""``leadscrew panel``: a machine watched and tuned in the browser."""

from __future__ import annotations

import contextlib
import os
import sys
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.exit_codes import say
from leadscrew.cli.options import Trust

if TYPE_CHECKING:
    from leadscrew.panel.process import Spec

FIRST = "fsmc_ballscrew"
"""The machine that the panel begins with unless one is named."""


def panel(
    study: Annotated[
        str | None,
        typer.Argument(metavar="STUDY", help="A study, path/file.py:NAME, or a machine or experiment file (.toml)."),
    ] = None,
    controller: Annotated[str | None, typer.Option("--controller", "-c", help="What it begins with.")] = None,
    scenario: Annotated[str | None, typer.Option("--scenario", "-s", help="What is asked of the machine.")] = None,
    host: Annotated[str, typer.Option(help="Address to serve; the default serves this computer alone.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 takes a free one.")] = 8420,
    token_file: Annotated[
        Path | None, typer.Option(help="File with the token of the printed link; without one, a new token each time.")
    ] = None,
    folder: Annotated[
        Path | None, typer.Option(help="For captures, presets, sessions and the log of who changed what.")
    ] = None,
    timeout: Annotated[
        float,
        typer.Option(min=1, max=3600, metavar="S", help="Back to safe values without the page in control for so long."),
    ] = 30.0,
    hal: Annotated[
        Path | None, typer.Option("--hal", help="Attach to the running LinuxCNC, as this file says.")
    ] = None,
    open_: Annotated[
        bool | None, typer.Option("--open/--no-open", help="Open the page in a browser; by itself on a desktop.")
    ] = None,
    trust: Trust = False,
) -> None:
    """Watch and tune a machine in the browser; Ctrl-C ends it.

    The machine is simulated: nothing moves. With --hal it is the one that LinuxCNC runs.
    """
    from leadscrew.panel.http_guard import is_loopback
    from leadscrew.panel.serve import Options, serve, token_for
    from leadscrew.userfile import trusting

    place = (folder or _own_folder()).expanduser().absolute()
    spec = replace(_spec(study, controller, scenario, hal, place), trust=trusting())
    options = Options(token_for(token_file), host, port, timeout, place)
    if token_file is not None and os.name == "posix" and token_file.stat().st_mode & 0o077:
        say(f"other users of this computer can read --token-file {token_file}: chmod 600 {token_file}")
    leading = place / f"open-{os.getpid()}.html"

    def said(link: str) -> None:
        typer.echo(f"Operator panel: {link}")
        typer.echo(f"{'LinuxCNC' if hal else 'Simulated machine: nothing moves'}. Files: {place}. Ctrl-C ends.")
        sys.stdout.flush()
        if open_ or (open_ is None and is_loopback(host) and _on_desktop()):
            _open(link, leading)

    try:
        code = serve(options, spec, said, typer.echo)
    finally:
        with contextlib.suppress(OSError):
            leading.unlink()
    raise typer.Exit(code)


def _spec(study: str | None, controller: str | None, scenario: str | None, hal: Path | None, folder: Path) -> Spec:
    """What the machine's process is to drive; names are checked there, files here."""
    from leadscrew import catalogue, names
    from leadscrew.kernel.parameters import nearest
    from leadscrew.panel.process import Spec
    from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

    if hal is not None:
        if study or controller or scenario:
            raise ValueRefused("--hal attaches to a real machine: give no STUDY, --controller or --scenario with it")
        if not hal.is_file():
            raise DataError(f"--hal {hal}: there is no such file")
        return Spec(str(folder), hal=str(hal.absolute()))
    if study is None:
        return Spec(str(folder), FIRST, controller or "", scenario or "", own=_own(controller))
    if not names.is_reference(study) and not study.endswith(".toml"):
        known = catalogue.study_names()
        if study not in known:
            raise NameUnknown(f"there is no study {study!r}{nearest(study, known)}")
        return Spec(str(folder), study, controller or "", scenario or "", own=_own(controller))
    from leadscrew.cli.subject import experiment_of

    found = experiment_of(study)
    name = names.absolute(found.study)
    own = None if controller is None else names.absolute(controller)
    return Spec(str(folder), name, own or found.controller or "", scenario or found.scenario or "",
                changes=dict(found.changes), seed=found.seed, named=(name,),
                own=_own(own or found.controller))  # fmt: skip


def _own(controller: str | None) -> tuple[str, ...]:
    """A controller that is named here may be chosen on the page too, be it of the study or not."""
    return (controller,) if controller else ()


def _own_folder() -> Path:
    from platformdirs import user_data_path

    return Path(user_data_path("leadscrew", appauthor=False)) / "panel"


def _on_desktop() -> bool:
    """Whether somebody sits in front of a browser."""
    if not sys.stdout.isatty():
        return False
    return sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _open(link: str, leading: Path) -> None:
    """Opens the link in a browser, by way of a file that only this user can read: any user of the computer can list the
    command lines of browsers.
    """
    import threading
    import webbrowser

    leading.unlink(missing_ok=True)
    with os.fdopen(os.open(leading, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
        file.write(f'<!doctype html><meta http-equiv="refresh" content="0; url={escape(link)}">\n')

    def work() -> None:
        if not webbrowser.open(leading.as_uri()):
            say("no browser could be opened; open the link yourself")

    threading.Thread(target=work, daemon=True).start()
