"""``leadscrew diff``: what differs between two controllers of a study."""

from __future__ import annotations

from typing import Annotated

import typer

from leadscrew.cli.options import Json, StudyName, Trust
from leadscrew.cli.output import deliver
from leadscrew.cli.subject import study_of


def diff(
    study: StudyName,
    a: Annotated[str, typer.Argument(metavar="A", help="A controller.")],
    b: Annotated[str, typer.Argument(metavar="B", help="Another one.")],
    trust: Trust = False,
    as_json: Json = False,
) -> None:
    """Print the changed equations and the changed parameter values of two controllers."""
    from leadscrew.report.difference import report_of
    from leadscrew.resolve import controller

    home = study_of(study)
    deliver(report_of(home.name, controller(home, a), controller(home, b), a, b), as_json=as_json)
