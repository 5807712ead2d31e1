"""``leadscrew export`` and ``leadscrew verify-export``: a controller to the machine, and proof that it is the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.cli.subject import Trust, experiment_of
from leadscrew.cli.values import parse
from leadscrew.util.escape import shell

if TYPE_CHECKING:
    from leadscrew.export.verdict import Verdict

SCHEMA_VERSION = 1


def export(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A study, a machine file, path/file.py:NAME of a study or Loop, or an experiment file.",
        ),
    ],
    target: Annotated[str, typer.Option("--target", "-t", help="c99, hal, fmu2 or fmu3.")],
    out: Annotated[Path, typer.Option(help="Folder to write; it must not exist yet.")],
    controller: Annotated[
        str | None,
        typer.Option(
            "--controller",
            "-c",
            help="Of the study, of the catalogue, path/file.py:NAME, a fuzzy system's file, "
            "or a controller file (.toml).",
        ),
    ] = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", "-s", help="Whose run gives the golden vectors; the study's first.")
    ] = None,
    changes: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a parameter; leadscrew list STUDY shows them."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Seconds of the golden vectors; the scenario's unless given.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Stem of the names in C; the controller's unless given.")] = None,
    real: Annotated[str, typer.Option(help="double, or float for processors without double precision.")] = "double",
    drive: Annotated[
        str | None, typer.Option(help="What the drive takes: torque, velocity, voltage, duty or position; checked.")
    ] = None,
    sources_only: Annotated[bool, typer.Option("--sources-only", help="FMU without its binary.")] = False,
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Export a controller to C99, LinuxCNC or an FMU, with golden vectors that prove it is the same."""
    from leadscrew import names
    from leadscrew.export.controller import export_controller
    from leadscrew.export.folder import write

    experiment = experiment_of(study)
    given = {"controller": controller, "scenario": scenario, "duration_s": duration}
    experiment = replace(experiment, **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]
    experiment = experiment.with_first_scenario()
    if changes:
        experiment = replace(experiment, changes={**experiment.changes, **parse(changes, experiment.settable())})
    loop = experiment.loop()
    block = loop.blocks["controller"]
    assert block is not None
    title = experiment.controller or block.name
    stem = names.stem(title) if name is None else name
    with busy(f"{title} to {target}"):
        core, record = export_controller(loop, experiment.seconds(), name=stem, title=title, real=real, drive=drive)
        manifest = write(core, record, target, out, loop=loop, binary=not sources_only)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "out": str(out), "files": sorted(p.name for p in out.iterdir()),
              "manifest": manifest})  # fmt: skip
        return
    golden = manifest["golden"]
    typer.echo(f"{out}: {', '.join(sorted(p.name for p in out.iterdir()))}")
    typer.echo(
        f"golden vectors: {golden['cycles']} periods of {core.period:g} s, {golden['verdict']} ({golden['note']})"
    )
    single = manifest.get("single_precision")
    if single:
        worst, unit = single["largest_difference_to_double"], single["unit"]
        typer.echo(
            f"single precision differs from double by at most {worst:.3g} {'' if unit == '1' else unit}".rstrip()
        )
    if "machine_left_out" in manifest:
        typer.echo(f"the simulated machine is left out: {manifest['machine_left_out']}")
    typer.echo(f"next: leadscrew verify-export {shell(out)}")


def verify_export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that leadscrew export wrote.")],
    as_json: Json = False,
) -> None:
    """Replay an export's golden vectors in everything that this machine has: compilers, LinuxCNC's HAL, FMU importers.

    Exit code 1 unless something ran and everything that ran is identical; what is missing here is listed as not run.
    """
    from leadscrew.export.folder import read_manifest, verify
    from leadscrew.export.verdict import NOT_RUN

    manifest = read_manifest(folder)
    with busy(f"{folder}: {manifest['title']}"):
        found = verify(folder)
    ran = [v for v in found if v.verdict != NOT_RUN]
    passed = bool(ran) and all(v.verdict == "identical" for v in ran)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "folder": str(folder), "name": manifest["name"],
              "target": manifest["target"], "passed": passed, "verdicts": [vars(v) for v in found]})  # fmt: skip
    else:
        unit = manifest["outputs"][0]["unit"]
        print_table(["target", "cycles", f"worst{f' / {unit}' if unit not in ('', '1') else ''}", "verdict", ""],
                    [row(v) for v in found], right=("cycles",))  # fmt: skip
        if not ran:
            typer.echo("\nnothing could be run on this machine")
    if not passed:
        raise typer.Exit(MISSED)


def row(verdict: Verdict) -> list[str]:
    """One line of the table."""
    worst: Any = "" if verdict.worst is None else f"{verdict.worst:.3g}"
    return [verdict.target, str(verdict.cycles) if verdict.cycles else "", worst, verdict.verdict, verdict.note]
