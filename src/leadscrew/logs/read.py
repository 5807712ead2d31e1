"""Any log file as a table: what is in it decides how it is read, its suffix only where that says nothing."""

from __future__ import annotations

from pathlib import Path

from leadscrew.kernel.errors import DataError, entry_point
from leadscrew.logs.table import Table
from leadscrew.reading import check_log


@entry_point
def read_table(path: str | Path) -> Table:
    """What a log file holds: text, Parquet, MATLAB, or the folder of ``leadscrew simulate --out``.

    Text is CSV, TSV, semicolons or white space, with or without a header, with a decimal point or comma; LinuxCNC's
    halscope and halsampler are known. The file is only read.

    Raises:
        DataError: it cannot be read, is too large, holds no rows, or is broken: file, row and column.
    """
    from leadscrew.logs.folder import MANIFEST, read_run
    from leadscrew.logs.mat import read_mat
    from leadscrew.logs.parquet import read_parquet
    from leadscrew.logs.text import read_text

    where = Path(path)
    try:
        folder = where.is_dir()
    except ValueError as problem:
        raise DataError(f"{str(path)!r}: is no name of a file ({problem})") from None
    if folder or where.name == MANIFEST:
        table = read_run(where)
    else:
        check_log(where)
        kind = _kind(where)
        table = {"parquet": read_parquet, "mat": read_mat, "text": read_text}[kind](where)
    if not table.rows:
        raise DataError(f"{where}: has columns but no rows of data")
    return table


def _kind(path: Path) -> str:
    try:
        with path.open("rb") as file:
            head = file.read(128)
    except OSError as problem:
        raise DataError(f"{path}: cannot be read ({problem.strerror or problem})") from None
    if head.startswith(b"PAR1"):
        return "parquet"
    if head.startswith(b"MATLAB ") or path.suffix.casefold() == ".mat":
        return "mat"
    return "parquet" if path.suffix.casefold() in (".parquet", ".pq") else "text"
