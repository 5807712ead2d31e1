"""``leadscrew fuzzy``: fuzzy systems in files, shown, converted, evaluated, drawn, learned from data, measured."""

from __future__ import annotations

import typer

from leadscrew.cli import fuzzy_bench, fuzzy_draw, fuzzy_eval, fuzzy_learn, fuzzy_show

app = typer.Typer(help="Fuzzy systems in files: .fis, .fll, .fcl, IEEE 1855 .xml.", no_args_is_help=True)
app.command("show")(fuzzy_show.show)
app.command("convert")(fuzzy_show.convert)
app.command("eval")(fuzzy_eval.eval_)
app.command("surface")(fuzzy_draw.surface)
app.command("activity")(fuzzy_draw.activity)
app.command("learn")(fuzzy_learn.learn)
app.command("bench")(fuzzy_bench.bench)
