"""Files that appear whole or not at all: written beside their place and renamed."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from leadscrew.kernel.errors import DataError
from leadscrew.unfinished import new_file, place


def save(data: str | bytes, path: str | Path, durable: bool = True) -> None:
    """Writes a file beside its place and renames it, so that it is never there in part; text as UTF-8, lines as given.

    A link stays, and the file that it points to is replaced. A device or pipe is written to. The file has the
    permissions that the umask leaves, or those of the file that it replaces.

    ``durable``: it is on the disk before it has its name, and so after a power cut is whole or not there. Without, a
    power cut may leave it empty or torn; the end of the process alone never does.

    Raises:
        DataError: it cannot be written.
    """
    named, beside = Path(path), None
    try:
        content = data.encode() if isinstance(data, str) else data
        if named.exists() and not named.is_file() and not named.is_dir():
            named.write_bytes(content)
            return
        target = place(named)
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, beside = new_file(target)
        with os.fdopen(handle, "wb") as out:
            out.write(content)
            if durable:
                out.flush()
                os.fsync(out.fileno())
        beside.replace(target)
    except UnicodeEncodeError:
        raise DataError(f"{named} cannot be written: a name or note in it is no Unicode text") from None
    except OSError as error:
        raise DataError(f"{named} cannot be written: {error.strerror or error}") from None
    finally:
        if beside is not None:
            beside.unlink(missing_ok=True)
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
