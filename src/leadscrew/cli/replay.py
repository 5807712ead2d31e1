"""``leadscrew replay``: the same bits again, or where they part."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import Json, Trust
from leadscrew.cli.output import busy, deliver
from leadscrew.report.report import File, Report, head


def replay(
    folder: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A run folder, the run.json in it, or a session of the panel (.toml)."),
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Of a session: a folder for its signals, all of them.")
    ] = None,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Run a saved run or a session of the panel again and compare it bit for bit.

    Exit code 0 only if it is identical.
    """
    if folder.suffix == ".toml":
        _session(folder, out, as_json)
    else:
        _run(folder, out, as_json)


def _run(folder: Path, out: Path | None, as_json: bool) -> None:
    from leadscrew._version import __version__
    from leadscrew.replay import replay as again
    from leadscrew.replay import versions
    from leadscrew.util.errors import ValueRefused

    if out is not None:
        raise ValueRefused(f"--out {out} is for sessions; the signals of {folder} lie in it already")
    with busy(f"replaying {folder}"):
        found = again(folder)
    data = {
        **head("replay"), "run": str(found.folder), "identical": found.identical,
        "first_difference": found.difference or None, "written_by": found.written_by or None,
        "replayed_by": __version__, "changed_since": list(found.causes), "rows": found.rows,
        "signals": list(found.signals), "wall_s": found.wall_s,
    }  # fmt: skip
    same = f"{found.rows} rows of {len(found.signals)} signals"
    other = [versions("run", found.written_by), *(f"changed since: {cause}" for cause in found.causes)]
    deliver(_report(data, found.identical, same, found.difference, other), as_json=as_json)


def _report(data: dict[str, Any], identical: bool, same: str, difference: str, other: list[str]) -> Report:
    if identical:
        return Report(data, [f"identical: {same}, bit for bit"])
    return Report(data, [f"not identical: {difference}", *other], code=MISSED)


def _session(path: Path, out: Path | None, as_json: bool) -> None:
    from leadscrew._version import __version__
    from leadscrew.operate import session_file
    from leadscrew.operate.recorder import EVERYTHING
    from leadscrew.replay import versions

    session = session_file.read(path)
    if out is not None:
        session_file.check_folder(out)
    with busy(f"replaying {path}"):
        found = session.run(record=() if out is None else EVERYTHING)
        if out is not None:
            session_file.write_folder(session, found, out)
    signals = len(found.operated.columns)
    data = {
        **head("replay"), "session": str(path), "identical": found.identical,
        "first_difference": found.difference or None, "written_by": session.written_by or None,
        "replayed_by": __version__, "rows": found.operated.period, "events": len(session.events),
        "signals": list(found.operated.columns), "digest": found.digest, "diverged": found.operated.diverged or None,
    }  # fmt: skip
    same = f"{found.operated.period} rows of {signals} signals, {len(session.events)} events"
    report = _report(data, found.identical, same, found.difference, [versions("session", session.written_by)])
    files = [File("out", out, "signals.parquet and session.toml")]
    deliver(replace(report, files=files), as_json=as_json)
