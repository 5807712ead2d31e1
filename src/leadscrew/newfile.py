"""Files that appear whole or not at all: written beside their place and renamed."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

from leadscrew.kernel.errors import DataError


def save(data: str | bytes, path: str | Path, durable: bool = True) -> None:
    """Writes a file beside its place and renames it, so that it is never there in part; text as UTF-8, lines as given.

    ``durable``: it is on the disk before it has its name, and so after a power cut is whole or not there. Without, a
    power cut may leave it empty or torn; the end of the process alone never does.

    Raises:
        DataError: it cannot be written.
    """
    target, beside = Path(path), ""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, beside = tempfile.mkstemp(prefix=f".{target.name}-", suffix=".tmp", dir=target.parent)
        with os.fdopen(handle, "wb") as out:
            out.write(data.encode() if isinstance(data, str) else data)
            if durable:
                out.flush()
                os.fsync(out.fileno())
        Path(beside).chmod(0o644)
        Path(beside).replace(target)
    except OSError as error:
        if beside:
            Path(beside).unlink(missing_ok=True)
        raise DataError(f"{target} cannot be written: {error.strerror or error}") from None
    if durable:
        _sync_folder(target.parent)


def _sync_folder(folder: Path) -> None:
    """The new name is on the disk too, where the system can say so of a folder."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
