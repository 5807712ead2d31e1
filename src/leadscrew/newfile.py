"""Files that appear whole or not at all: written beside their place and renamed."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from leadscrew.kernel.errors import DataError


def save(data: str | bytes, path: str | Path) -> None:
    """Writes a file beside its place and renames it, so that it is never there in part; text as UTF-8, lines as given.

    Raises:
        DataError: it cannot be written.
    """
    target, beside = Path(path), ""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, beside = tempfile.mkstemp(prefix=f".{target.name}-", suffix=".tmp", dir=target.parent)
        with os.fdopen(handle, "wb") as out:
            out.write(data.encode() if isinstance(data, str) else data)
        Path(beside).chmod(0o644)
        Path(beside).replace(target)
    except OSError as error:
        if beside:
            Path(beside).unlink(missing_ok=True)
        raise DataError(f"{target} cannot be written: {error.strerror or error}") from None
