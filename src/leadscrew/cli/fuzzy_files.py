"""What the commands of ``leadscrew fuzzy`` share: reading a system, texts of options, files that appear whole."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused

if TYPE_CHECKING:
    import numpy as np

    from leadscrew.fuzzy.system import System


SystemFile = Annotated[
    Path, typer.Argument(metavar="FILE", help="A fuzzy system: .fis, .fll, .fcl, or .xml (read only).")
]
LeaveOut = Annotated[
    bool,
    typer.Option("--leave-out-unknown", help="Leave out rules that name a variable or term that does not exist."),
]
HINT = "--leave-out-unknown leaves such rules out"


def system_of(path: Path, leave_out_unknown: bool) -> System:
    """The system in a file; where ``--leave-out-unknown`` would read it, the error says so.

    Raises:
        DataError: it is broken: file, line, column and what was expected.
    """
    from leadscrew.fuzzy import formats

    try:
        return formats.read(path, leave_out_unknown=leave_out_unknown)
    except DataError as error:
        if leave_out_unknown or not _would_read(path):
            raise
        raise DataError(f"{error} ({HINT})") from None


def _would_read(path: Path) -> bool:
    from leadscrew.fuzzy import formats

    try:
        formats.read(path, leave_out_unknown=True)
    except DataError:
        return False
    return True


# ---- texts of the command line
def number_of(text: str, what: str) -> float:
    """A text as a number, infinite ones included.

    Raises:
        ValueRefused: it is none.
    """
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if math.isnan(found):
        raise ValueRefused(f"{what} = {text!r}: expected a number")
    return found


def pairs(texts: Sequence[str], what: str) -> dict[str, str]:
    """``NAME=VALUE`` texts by name; a name may hold ``=`` only where it is the last sign.

    Raises:
        ValueRefused: no ``=``, or a name given twice.
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name or not value.strip():
            raise ValueRefused(f"{what} {text!r}: expected NAME=VALUE")
        if name in found:
            raise ValueRefused(f"{what} {name}: given twice")
        found[name] = value.strip()
    return found


def numbers(texts: Sequence[str], what: str) -> dict[str, float]:
    """``NAME=NUMBER`` texts by name.

    Raises:
        ValueRefused: no ``=``, a name given twice, or no number.
    """
    return {name: number_of(value, f"{what} {name}".strip()) for name, value in pairs(texts, what).items()}


def known(name: str, names: Sequence[str], what: str) -> str:
    """The name, where it is one of those.

    Raises:
        NameUnknown: it is not; names the nearest.
    """
    from leadscrew.kernel.parameters import nearest

    if name not in names:
        raise NameUnknown(f"there is no {what} {name!r}{nearest(name, list(names))}")
    return name


# ---- files that appear whole
def columns_of(path: Path) -> list[str]:
    """The names of the columns of a CSV or Parquet file.

    Raises:
        DataError: it cannot be read.
    """
    if path.suffix.casefold() == ".parquet":
        from leadscrew.util import parquet

        return parquet.read(path).names
    from leadscrew.fuzzy.formats.place import load

    lines = (line for line in load(path)[0].splitlines() if line.strip() and not line.lstrip().startswith("#"))
    return [cell.strip().strip('"') for cell in next(lines, "").split(",")]


def table_of(path: Path, columns: Sequence[str]) -> dict[str, np.ndarray]:
    """Columns of a CSV or Parquet file as numbers.

    Raises:
        DataError: no such file, a column missing, or a cell that is no finite number: says row and column.
    """
    if path.suffix.casefold() != ".parquet":
        from leadscrew.logs.csv_columns import read_log

        return read_log(path, columns)
    import numpy as np

    from leadscrew.kernel.parameters import nearest
    from leadscrew.util import parquet

    table, found = parquet.read(path), {}
    for name in columns:
        if name in table.texts or name in table.other:
            raise DataError(f"{path}: the column {name!r} holds no numbers")
        if name not in table.numbers:
            raise DataError(f"{path}: the column {name!r} is missing{nearest(name, table.names)}")
        found[name] = table.numbers[name]
        bad = ~np.isfinite(found[name])
        if bad.any():
            at = int(np.argmax(bad))
            raise DataError(f"{path}, row {at + 1}, column {name!r}: {found[name][at]} is not a finite number")
    if not table.rows:
        raise DataError(f"{path}: has no rows of data")
    return found


def save_table(names: Sequence[str], rows: np.ndarray, path: Path) -> None:
    """Writes columns of numbers as CSV, Parquet or ``.fld``, by the suffix.

    Raises:
        ValueRefused: a name that ``.fld`` cannot express.
        DataError: it cannot be written.
    """
    kind = path.suffix.casefold()
    if kind == ".parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        held = io.BytesIO()
        pq.write_table(pa.table([rows[:, i] for i in range(len(names))], names=list(names)), held)
        atomic_write(held.getvalue(), path)
        return
    if kind == ".fld" and (spaced := [n for n in names if not n or any(c.isspace() for c in n)]):
        raise ValueRefused(f"a .fld file cannot express the name {spaced[0]!r}: it is empty or holds a space")
    atomic_write(text_table(names, rows, " " if kind == ".fld" else ",").encode(), path)


def text_table(names: Sequence[str], rows: np.ndarray, between: str = ",") -> str:
    """Columns of numbers as text, each number in the fewest digits that give it back."""
    import csv

    held = io.StringIO()
    writer = csv.writer(held, delimiter=between, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([repr(x) for x in row] for row in rows.tolist())
    return held.getvalue()
