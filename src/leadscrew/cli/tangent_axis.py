"""Options of ``leadscrew tangent cut`` and ``compensate`` about the axis of a program that does not say it itself."""

from __future__ import annotations

from typing import Annotated

import typer

ZeroOfOthers = Annotated[
    float | None,
    typer.Option(
        "--zero",
        metavar="DEG",
        help="Heading, counter-clockwise from +X, at which the axis reads 0: 0, or what a program of ours says.",
    ),
]
ClockwiseOfOthers = Annotated[
    bool | None,
    typer.Option("--clockwise/--counter-clockwise", help="How the axis counts; a program of ours says it."),
]
