"""``leadscrew tangent``: from a drawing to a compensated G-code program; and nets that learn while they cut."""

from __future__ import annotations

import typer

from leadscrew.cli import tangent_compensate, tangent_cut, tangent_gcode, tangent_show, tangent_train

app = typer.Typer(
    help="Cut with a tangential knife: drawings to G-code, and compensated G-code from a measured piece.",
    no_args_is_help=True,
)
app.command("show")(tangent_show.show)
app.command("gcode")(tangent_gcode.gcode)
app.command("cut")(tangent_cut.cut)
app.command("compensate")(tangent_compensate.compensate)
app.command("train")(tangent_train.train)
