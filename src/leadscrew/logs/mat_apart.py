"""What a MATLAB file holds, read in a process of its own: a broken one can crash SciPy's reader."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew import apart as process


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
    from leadscrew.logs import mat

    said: list[tuple[str, str, str | None]] = []
    arrays: dict[str, np.ndarray] = {}
    for k, (name, value) in enumerate(mat.flat(mat.read(path)).items()):
        array = None if isinstance(value, str | dict) else np.asarray(value)
        if array is not None and array.dtype.kind in "fiub" and array.ndim <= 2:
            arrays[f"a{k}"] = array
            said.append((name, "array", None))
        else:
            said.append((name, "text", value) if isinstance(value, str) else (name, "other", None))
    arrays["said"] = np.frombuffer(json.dumps(said).encode(), np.uint8)
    np.savez(out, allow_pickle=False, **arrays)


__all__ = ["apart", "loaded"]
