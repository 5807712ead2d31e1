"""``leadscrew diff``: what differs between two controllers of a study."""

from __future__ import annotations

from typing import Annotated

import typer

from leadscrew.cli.output import Json, emit, print_table
from leadscrew.cli.subject import StudyName, Trust, study_of


def diff(
    study: StudyName,
    a: Annotated[str, typer.Argument(metavar="A", help="A controller.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Another one.")],
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Print the changed equations and the changed parameter values of two controllers."""
    from leadscrew.figures.formats import number
    from leadscrew.report.difference import equations, parameters
    from leadscrew.resolve import controller

    found = study_of(study)
    first, second = controller(found, a), controller(found, b)
    lines, rows = equations(first, second, a, b), parameters(first, second)
    if as_json:
        emit({"study": found.name, "a": a, "b": b, "equations": lines, "parameters": [r._asdict() for r in rows]})
        return
    for line in lines or ["the equations are the same"]:
        colour = {"+": "green", "-": "red", "@": "cyan"}.get(line[:1]) if lines else None
        typer.echo(typer.style(line, fg=colour) if colour else line)
    typer.echo()
    if rows:
        print_table(
            ["parameter", a, b, "unit"], [(r.key, number(r.a), number(r.b), r.unit) for r in rows], right=(a, b)
        )
    else:
        typer.echo("the parameters are the same")
