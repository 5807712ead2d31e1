"""A folder that appears only when it is complete: written beside, then renamed."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from leadscrew.kernel.errors import DataError


@contextmanager
def appearing(folder: str | Path) -> Iterator[Path]:
    """A place to write to, which becomes ``folder`` at the end; what fails on the way leaves nothing behind.

    Raises:
        DataError: the folder exists already and is not empty, or cannot be written.
    """
    target = Path(folder)
    try:
        if target.exists() and (not target.is_dir() or any(target.iterdir())):
            raise DataError(f"{target} exists already; choose another folder or remove it")
        if target.parent.exists() and not target.parent.is_dir():
            raise DataError(f"{target} cannot be written: {target.parent} is not a folder")
        target.parent.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=f".{target.name}-", suffix=".partial", dir=target.parent))
    except OSError as error:
        raise DataError(f"{target} cannot be written: {error.strerror or error}") from None
    try:
        yield beside
        beside.chmod(0o755)
        if target.exists():
            target.rmdir()
        beside.replace(target)
    except OSError as error:
        shutil.rmtree(beside, ignore_errors=True)
        raise DataError(f"{target} cannot be written: {error.strerror or error}") from None
    except BaseException:
        shutil.rmtree(beside, ignore_errors=True)
        raise
