"""``leadscrew export`` and ``leadscrew verify-export``: a controller to the machine, and proof that it is the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from leadscrew.cli.exit_codes import MISSED
from leadscrew.cli.options import Changes, Controller, Duration, Json, Scenario, Trust
from leadscrew.cli.output import busy, deliver
from leadscrew.cli.subject import experiment_of
from leadscrew.cli.values import parse
from leadscrew.figures.table import number, unit
from leadscrew.report.report import Report, TextTable, head
from leadscrew.util.escape import shell


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
    controller: Controller = None,
    scenario: Scenario = None,
    changes: Changes = None,
    duration: Duration = None,
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
    deliver(_exported(out, manifest, core.period), as_json=as_json)


def _exported(out: Path, manifest: dict[str, Any], period: float) -> Report:
    golden, single = manifest["golden"], manifest.get("single_precision")
    files = sorted(p.name for p in out.iterdir())
    parts = [
        f"{out}: {', '.join(files)}",
        f"golden vectors: {golden['cycles']} periods of {period:g} s, {golden['verdict']} ({golden['note']})",
    ]
    if single:
        worst = f"{number(single['largest_difference_to_double'], 3)} {unit(single['unit'])}".rstrip()
        parts.append(f"single precision differs from double by at most {worst}")
    if "machine_left_out" in manifest:
        parts.append(f"the simulated machine is left out: {manifest['machine_left_out']}")
    parts.append(f"next: leadscrew verify-export {shell(out)}")
    return Report({**head("export"), "out": str(out), "files": files, "manifest": manifest}, parts)


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
    measured = manifest["outputs"][0]["unit"]
    rows = [[v.target, str(v.cycles or ""), "" if v.worst is None else number(v.worst, 3), v.verdict, v.note]
            for v in found]  # fmt: skip
    heads = ["target", "cycles", f"worst ({unit(measured)})" if unit(measured) else "worst", "verdict", ""]
    report = Report(
        {**head("verify-export"), "folder": str(folder), "name": manifest["name"], "target": manifest["target"],
         "passed": passed, "verdicts": [vars(v) for v in found]},
        parts=[TextTable(heads, rows, [False, True, True, False, False])],
        verdict="" if ran else "nothing could be run on this machine",
        code=0 if passed else MISSED,
    )  # fmt: skip
    deliver(report, as_json=as_json)
