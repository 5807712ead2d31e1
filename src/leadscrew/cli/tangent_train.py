"""``leadscrew tangent train``: a performance network for a decision table, and whether it is safe to learn with."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.cli.door import say
from leadscrew.cli.output import Json, emit, print_table, progress
from leadscrew.cli.tangent_files import SCHEMA_VERSION
from leadscrew.kernel.errors import ValueRefused

if TYPE_CHECKING:
    from leadscrew.neural.training import Trained


def train(
    table: Annotated[
        Path | None,
        typer.Option(
            "--table", metavar="FILE.csv", help="13 x 13 levels, rows EC, columns E; the paper's unless given."
        ),
    ] = None,
    hidden: Annotated[int, typer.Option(metavar="N", help="Hidden neurons.")] = 6,
    biases: Annotated[str, typer.Option(help="none, output, hidden or all.")] = "none",
    linear: Annotated[bool, typer.Option("--linear", help="A linear output in place of 6 tanh.")] = False,
    method: Annotated[str, typer.Option(help="ga, ga+polish, cma, cma+polish, pymoo or pymoo+polish.")] = "ga+polish",
    seed: Annotated[int, typer.Option(help="Of the search.")] = 0,
    population: Annotated[int, typer.Option(metavar="N", help="Networks in a generation.")] = 80,
    generations: Annotated[int, typer.Option(metavar="N", help="Of the search.")] = 600,
    tries: Annotated[int, typer.Option(metavar="N", help="Searches before training gives up.")] = 8,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE.json", help="File of the network.")] = None,
    as_json: Json = False,
) -> None:
    """Train the network that corrects a self-organising controller, and check that it cannot run away.

    A network that would drive the loop the wrong way is not written: exit code 2. One that goes the right way and knows
    the table less well than asked is written with a note: exit code 1.
    """
    from leadscrew.cli.tune import free
    from leadscrew.neural.performance import TABLE, Shape, read_table, write_net
    from leadscrew.neural.training import train as trained

    if out is not None and out.suffix != ".json":
        raise ValueRefused(f"--out {out}: the file of a network ends in .json")
    wanted = TABLE if table is None else read_table(table)
    shape = Shape(hidden, biases, linear)  # type: ignore[arg-type]
    free([out])
    with progress() as bar:
        searches = 0

        def report(done: int, total: int) -> None:
            nonlocal searches
            searches += done == 1
            bar(f"{shape.name}: search {searches}", done / total)

        found = trained(wanted, shape, method, seed, population, generations, tries, report)  # type: ignore[arg-type]
    name = "Table 1 of the paper" if table is None else str(table)
    if out is not None:
        write_net(found.net, out.resolve() if out.is_symlink() else out, {"table": name, **found.as_dict()})
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "table": name, **found.as_dict(), "net": found.net._asdict(),
              "file": None if out is None else str(out)})  # fmt: skip
    else:
        print_trained(found, name)
        if out is not None:
            typer.echo(f"\n{out}: the network")
    for note in found.notes:
        say(f"leadscrew: note: {note}")
    if not found.safety.accepted:
        raise typer.Exit(1)


def print_trained(found: Trained, name: str) -> None:
    """The result in words."""
    from leadscrew.neural.safety import NEAR, ORIGIN, WORST_RMSE

    safe = found.safety
    searches = f"{found.tries} search{'es' if found.tries > 1 else ''}"
    typer.echo(
        f"{name}: {found.shape.name}, {found.shape.weights} weights; {found.method}, seed {found.seed}, "
        f"{searches} in {found.wall_s:.1f} s\n"
    )
    low, high = safe.slope_range
    rows = [
        ("RMSE, levels", f"{safe.rmse:.3f}", f"{WORST_RMSE:g} or less"),
        ("largest difference, levels", f"{safe.largest:.2f}", ""),
        ("cells exact, rounded", f"{100.0 * safe.exact:.0f} %", ""),
        ("cells within one level", f"{100.0 * safe.within_one:.0f} %", ""),
        ("P(0, 0), levels", f"{safe.origin:.3f}", f"below {ORIGIN:g} in size"),
        ("slope dP/dE at the origin", f"{safe.slope:.2f}", f"{low:g} to {high:g}"),
        (f"largest P sign(E), |E| to {NEAR:g}", f"{safe.wrong_way:.4f}", "below 0"),
    ]
    print_table(["of the network", "found", "asked"], rows, right=("found",))
