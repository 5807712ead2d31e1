"""``leadscrew design rejection``: a law of the XY table with the smallest rows of Table II under given bounds."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import Annotated

import typer

from leadscrew.cli.output import Json, busy, emit, print_table
from leadscrew.kernel.errors import NameUnknown, ValueRefused

SCHEMA_VERSION = 1
STUDY = "npid_xytable"
GOAL = "mean row of Table II, um"


def rejection(
    law: Annotated[str, typer.Argument(help="pid, npid or npid_split.")],
    rest: Annotated[
        float | None, typer.Option(metavar="MV", help="Change of the output at rest, rms a sample, at most.")
    ] = None,
    work: Annotated[
        float | None, typer.Option(metavar="MV", help="Change of the output at work, rms a sample, at most.")
    ] = None,
    ms: Annotated[float, typer.Option(help="Peak of the sensitivity around every error, at most.")] = 1.6,
    feed_forward: Annotated[
        bool, typer.Option("--feed-forward", help="With the inverse plant as feed-forward, which knows the plant.")
    ] = False,
    amplitude: Annotated[float, typer.Option(metavar="MM", help="Of the motion, a sine of 0.7 Hz.")] = 1.0,
    budget: Annotated[int, typer.Option(metavar="N", help="Settings to try.")] = 3000,
    seed: Annotated[int, typer.Option(help="Of the search.")] = 1,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="Controller file.")] = None,
    as_json: Json = False,
) -> None:
    """Tune a law of the XY table for the smallest rows of Table II; the same search and bounds for every law.

    Each is proved stable on the twelve plants of the robustness box. What is printed was measured under phases of the
    forces that the search did not see. Exit code 1 where a bound is missed there.
    """
    from leadscrew import controller_file, resolve
    from leadscrew._version import __version__
    from leadscrew.cli.tune import free
    from leadscrew.kernel.sheet import nearest
    from leadscrew.studies.lab import Lab
    from leadscrew.studies.npid_xytable.search import LAWS, searched

    if law not in LAWS:
        raise NameUnknown(f"there is no law {law!r}{nearest(law, list(LAWS))}; there are {', '.join(LAWS)}")
    if rest is None and work is None:
        raise ValueRefused("say how active the drive may be: --rest MV, --work MV, or both")
    for name, value in (("--rest", rest), ("--work", work), ("--amplitude", amplitude), ("--ms", ms - 1.0)):
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise ValueRefused(f"{name}: must be {'above 1' if name == '--ms' else 'positive'}")
    if budget < 8:
        raise ValueRefused(f"--budget {budget}: a search needs 8 settings at least")
    if out is not None and out.suffix != ".toml":
        raise ValueRefused(f"--out {out}: a controller file ends in .toml")
    free([out])
    limits = {"rest": math.inf if rest is None else rest, "work": math.inf if work is None else work}
    with busy("tuning"):
        found = searched(
            Lab(resolve.study(STUDY)), law, feed_forward=feed_forward, rest_mv=limits["rest"],
            work_mv=limits["work"], ms=ms, amplitude_mm=amplitude, budget=budget, seed=seed,
        )  # fmt: skip
    words = ["leadscrew", "design", "rejection", law]
    words += [f"--{key}={value:g}" for key, value in limits.items() if math.isfinite(value)]
    words += [f"--ms={ms:g}", f"--amplitude={amplitude:g}", f"--budget={budget}", f"--seed={seed}"]
    words += ["--feed-forward"] if feed_forward else []
    measured = {
        GOAL: found.row_um, "Ms": found.ms, "change of the output at rest, mV": found.rest_mv,
        "change of the output at work, mV": found.work_mv,
    }  # fmt: skip
    bounds = [f"Ms<={ms:g}", "proved on the robustness box"]
    bounds += [f"change of the output at {key}, mV<={value:g}" for key, value in limits.items() if math.isfinite(value)]
    tuning = {
        "made_by": "leadscrew design rejection", "leadscrew": __version__, "command": shlex.join(words),
        "minimise": [GOAL], "subject_to": bounds, "budget": budget, "seed": seed, "holds": found.holds,
        "at_an_end": list(found.ends), "held_out": measured,
    }  # fmt: skip
    base = f"ours.{law}_ff" if feed_forward else law
    if out is not None:
        controller_file.write(out, controller_file.ControllerFile(STUDY, base, found.parameters, tuning))
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "controller": base, "parameters": found.parameters, **tuning})
    else:
        rows = [[key, f"{value:.4g}"] for key, value in (measured | found.parameters).items()]
        print_table(["", base], rows)
        typer.echo(f"\n{'bounds kept' if found.holds else 'A BOUND IS MISSED'}: {'; '.join(bounds)}")
        if found.ends:
            typer.echo(f"at an end of its range: {', '.join(found.ends)}")
    raise typer.Exit(0 if found.holds else 1)
