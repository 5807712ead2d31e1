"""MATLAB files up to version 7: vectors are columns, single numbers constants, structures are looked into once.

A file of version 7.3 is HDF5 and is read where h5py is installed. Files are read in a process of their own: a broken
one can crash SciPy's reader.
"""

from __future__ import annotations

import json
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.logs.table import Table
from leadscrew.util import separate_process as process
from leadscrew.util.errors import DataError
from leadscrew.util.reading import check_cells, check_log


def loaded(path: Path) -> dict[str, Any]:
    """Arrays of numbers and texts by name, None for what is neither; ``structure.field`` for parts of a structure.

    Raises:
        DataError: it cannot be read; its reader crashed, took too long or more memory than it may.
    """
    with tempfile.TemporaryDirectory() as folder:
        sent = Path(folder) / "held.npz"
        process.run(__name__, path, sent)
        with np.load(sent, allow_pickle=False) as held:
            said = json.loads(held["said"].tobytes())
            return {name: held[f"a{k}"] if kind == "array" else text for k, (name, kind, text) in enumerate(said)}


def apart(path: Path, out: Path) -> None:
    """Reads the file and writes what it holds to ``out``.

    Raises:
        DataError: it cannot be read.
    """
    said: list[tuple[str, str, str | None]] = []
    arrays: dict[str, np.ndarray] = {}
    for k, (name, value) in enumerate(flat(read(path)).items()):
        array = None if isinstance(value, str | dict) else np.asarray(value)
        if array is not None and array.dtype.kind in "fiub" and array.ndim <= 2:
            arrays[f"a{k}"] = array
            said.append((name, "array", None))
        else:
            said.append((name, "text", value) if isinstance(value, str) else (name, "other", None))
    arrays["said"] = np.frombuffer(json.dumps(said).encode(), np.uint8)
    np.savez(out, allow_pickle=False, **arrays)


PERIODS = ("ts", "t_s", "dt", "tsamp", "sampletime", "sample_time", "period", "period_s", "samplingperiod", "h")
"""Names of constants, in lower case, that are taken as the sampling period in seconds."""


def read_mat(path: Path) -> Table:
    """The table of a MATLAB file.

    Raises:
        DataError: it cannot be read, holds no vectors, or is of version 7.3 and h5py is not there.
    """
    check_log(path)
    held = loaded(path)
    notes: list[str] = []
    columns, constants = _sorted(held, str(path), notes)
    period = next((v for n, v in constants.items() if n.split(".")[-1].casefold() in PERIODS and v > 0.0), None)
    return Table(columns, {}, {}, str(path), notes, constants, period=period, form="MATLAB")


def read(path: Path) -> dict[str, Any]:
    """What SciPy or h5py finds in the file; a broken one can crash SciPy, so it is read in a process of its own.

    Raises:
        DataError: it cannot be read.
    """
    import warnings

    from scipy.io import loadmat

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return loadmat(path, simplify_cells=True)
    except NotImplementedError:
        return _hdf5(path)
    except MemoryError:
        raise DataError(f"{path}: is broken: it asks for more memory than there is") from None
    except Exception as problem:  # SciPy raises errors of many kinds for a broken file.
        raise DataError(f"{path}: is no MATLAB file that can be read ({_one_line(problem)})") from None


def _hdf5(path: Path) -> dict[str, Any]:
    try:
        import h5py  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        raise DataError(
            f"{path}: is a MATLAB file of version 7.3 (HDF5); save it in MATLAB with: save('{path.name}', '-v7'), or "
            "install h5py"
        ) from None
    try:
        with h5py.File(path, "r") as file:
            return {name: _of_group(item, h5py) for name, item in file.items() if not name.startswith("#")}
    except (OSError, ValueError, TypeError, KeyError, RuntimeError) as problem:
        raise DataError(f"{path}: cannot be read ({_one_line(problem)})") from None


def _of_group(item: Any, h5py: Any) -> Any:
    if isinstance(item, h5py.Group):
        return {name: part[()] for name, part in item.items() if isinstance(part, h5py.Dataset)}
    # MATLAB writes a column of n as an array of 1 by n.
    return np.asarray(item[()]).T


def flat(held: dict[str, Any]) -> dict[str, Any]:
    """Everything by name, with ``structure.field`` for what stands in a structure."""
    found: dict[str, Any] = {}
    for name, value in held.items():
        if name.startswith("__"):
            continue
        if isinstance(value, dict):
            found.update({f"{name}.{part}": inside for part, inside in value.items()})
        else:
            found[name] = value
    return found


def _sorted(held: dict[str, Any], source: str, notes: list[str]) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Columns of the usual length, and constants; what is neither is named in the notes."""
    vectors: dict[str, np.ndarray] = {}
    constants: dict[str, float] = {}
    other = []
    for name, value in held.items():
        array = np.asarray(value)
        if array.dtype.kind not in "fiub" or array.ndim > 2 or array.size == 0:
            other.append(name)
        elif array.size == 1:
            constants[name] = float(array.reshape(-1)[0])
        elif array.ndim == 1 or 1 in array.shape:
            vectors[name] = array.reshape(-1)
        else:
            tall = array if array.shape[0] >= array.shape[1] else array.T
            check_cells(source, *tall.shape)
            vectors.update({f"{name}_{k + 1}": tall[:, k] for k in range(tall.shape[1])})
    if not vectors:
        raise DataError(f"{source}: holds no vectors of numbers, only {', '.join(held) or 'nothing'}")
    lengths = Counter(len(v) for v in vectors.values())
    rows = max(lengths, key=lambda n: (lengths[n], n))
    check_cells(source, rows, lengths[rows])
    notes += [
        f"{name!r} has {len(v)} values where the others have {rows}: left out"
        for name, v in vectors.items() if len(v) != rows
    ]  # fmt: skip
    if other:
        notes.append(f"left out, being no vectors of numbers: {', '.join(other)}")
    return {n: v.astype(float) for n, v in vectors.items() if len(v) == rows}, constants


def _one_line(problem: BaseException) -> str:
    return " ".join(str(problem).split())[:200] or type(problem).__name__
