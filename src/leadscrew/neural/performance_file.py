"""Files of the performance measurement: its table as CSV, its network as JSON.

A table has 13 lines of 13 numbers of -6 to 6, ``EC`` from -6 down to 6, ``E`` from -6 to 6 across; or the same below a
line and behind a column that name the levels, as Table 1 of the paper of the study ``sofnn_tangent`` does.

A network is a JSON object: ``format``, ``version``, ``hidden`` (``h`` pairs), ``hidden_bias`` (``h``), ``out`` (``h``),
``out_bias``, ``linear``, and ``made``, which says how it came about and is not read back. Names as in
:class:`leadscrew.neural.performance.Performance`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.csvlines import number, read_lines
from leadscrew.kernel.errors import DataError
from leadscrew.neural.performance import FORMAT, LEVELS, MOST, VERSION, Performance
from leadscrew.neural.performance_shape import MOST_HIDDEN
from leadscrew.reading import json_object

EXPECTED = "13 lines of 13 numbers of -6 to 6, with or without the levels around them"
LARGEST = 1e6
"""A weight may have this size."""


def read_table(path: str | Path) -> np.ndarray:
    """The table of a CSV file, 13 x 13: rows ``EC``, columns ``E``, both from -6 to 6.

    Raises:
        DataError: names file, row and what is wrong: shape, a cell that is no number or outside -6 to 6, levels in
            another order.
    """
    file = Path(path)
    lines = read_lines(file, EXPECTED)
    if len(lines) == 14:
        row, cells = lines[0]
        _levels(file, row, cells[1:], "E")
        _levels(file, lines[1][0], [cells[0] for _, cells in lines[1:]], "EC")
        lines = [(row, cells[1:]) for row, cells in lines[1:]]
    if len(lines) != 13:
        raise DataError(f"{file}: {len(lines)} lines; expected {EXPECTED}")
    table = np.empty((13, 13))
    for i, (row, cells) in enumerate(lines):
        if len(cells) != 13:
            raise DataError(f"{file}, row {row}: {len(cells)} numbers; expected {EXPECTED}")
        for j, cell in enumerate(cells):
            value = number(file, row, f"E = {LEVELS[j]:g}", cell)
            if abs(value) > MOST:
                raise DataError(f"{file}, row {row}, column 'E = {LEVELS[j]:g}': {cell} is outside -6 to 6")
            table[i, j] = value
    return table


def _levels(file: Path, row: int, cells: list[str], name: str) -> None:
    """Refuses levels that are not -6 to 6 in order."""
    try:
        found = [float(cell) for cell in cells]
    except ValueError:
        found = []
    if found != LEVELS.tolist():
        raise DataError(f"{file}, row {row}: the levels of {name} are {', '.join(cells)}; expected -6 to 6 in order")


def net_text(net: Performance, made: Mapping[str, Any] | None = None) -> str:
    """The text of a network's file."""
    lines = {
        "format": FORMAT,
        "version": VERSION,
        "hidden": np.asarray(net.hidden).tolist(),
        "hidden_bias": np.asarray(net.hidden_bias).tolist(),
        "out": np.asarray(net.out).tolist(),
        "out_bias": float(net.out_bias),
        "linear": bool(net.linear),
        "made": dict(made or {}),
    }
    return "{\n" + ",\n".join(f" {json.dumps(key)}: {json.dumps(value)}" for key, value in lines.items()) + "\n}\n"


def write_net(net: Performance, path: str | Path, made: Mapping[str, Any] | None = None) -> None:
    """Writes a network's file, whole or not at all; numbers come back to the last bit.

    Raises:
        DataError: it cannot be written.
    """
    from leadscrew.newfile import save

    save(net_text(net, made), path)


def read_net(path: str | Path) -> Performance:
    """The network of a file.

    Raises:
        DataError: names the file and what is wrong with it.
    """
    file = Path(path)
    kept = json_object(file)
    if kept.get("format") != FORMAT:
        raise DataError(f"{file}: is not a performance network; expected an object with format {FORMAT!r}")
    if kept.get("version") != VERSION:
        raise DataError(f"{file}: has version {kept.get('version')!r}; this program reads {VERSION}")
    out = _numbers(file, kept, "out", 1)
    h = len(out)
    if not 1 <= h <= MOST_HIDDEN:
        raise DataError(f"{file}: {h} numbers in 'out'; expected 1 to {MOST_HIDDEN}, one a hidden neuron")
    hidden = _numbers(file, kept, "hidden", 2)
    bias = _numbers(file, kept, "hidden_bias", 1)
    if hidden.shape != (h, 2) or bias.shape != (h,):
        raise DataError(f"{file}: 'hidden' is {hidden.shape}, 'hidden_bias' {bias.shape}; expected {(h, 2)}, {(h,)}")
    linear = kept.get("linear", False)
    if not isinstance(linear, bool):
        raise DataError(f"{file}: 'linear' is {linear!r}; expected true or false")
    return Performance(hidden, bias, out, float(_numbers(file, kept, "out_bias", 0)), linear)


def _numbers(file: Path, kept: Mapping[str, Any], key: str, depth: int) -> np.ndarray:
    """Numbers of a key, nested so deep."""
    try:
        given = kept[key]
        values = np.array(given, dtype=float)
    except KeyError:
        raise DataError(f"{file}: {key!r} is missing") from None
    except (TypeError, ValueError):
        raise DataError(f"{file}: {key!r} does not hold numbers in rows of equal length") from None
    if values.ndim != depth or isinstance(given, bool | str):
        raise DataError(f"{file}: {key!r} holds {values.ndim} levels of lists; expected {depth}")
    if not np.isfinite(values).all() or np.abs(values).max(initial=0.0) > LARGEST:
        raise DataError(f"{file}: {key!r} holds a number that is not finite or above {LARGEST:g} in size")
    return values
