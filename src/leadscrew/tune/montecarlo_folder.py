"""The folder of a Monte Carlo report: there when it is complete; an older one of ours is replaced at once.

It is written in ``.NAME-MACHINE-PID-*.partial`` beside its place. What a killed process left there is cleared by the
next one that writes to the same place on the same machine.
"""

from __future__ import annotations

import os
import re
import shutil
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from leadscrew import reading
from leadscrew.kernel.errors import DataError

KIND = "leadscrew montecarlo"
"""By this, in its ``summary.json``, a folder is known to be ours to replace."""
SUMMARY = "summary.json"


def claimable(folder: str | Path) -> Path:
    """The folder, if a report may be written there: it does not exist, is empty, or holds an older report.

    Raises:
        DataError: it holds something else, or cannot be written.
    """
    target = Path(folder)
    try:
        if target.is_symlink() or (target.exists() and not target.is_dir()):
            raise DataError(f"{target} is not a folder; choose another place for the report")
        if target.exists() and any(target.iterdir()) and not _ours(target):
            raise DataError(f"{target} holds something that is not a Monte Carlo report; choose another folder")
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target.parent):
            pass
    except OSError as error:
        raise DataError(f"{target} cannot be written: {error.strerror or error}") from None
    return target


def _ours(folder: Path) -> bool:
    try:
        return reading.json_object(folder / SUMMARY).get("kind") == KIND
    except DataError:
        return False


@contextmanager
def placed(folder: str | Path) -> Iterator[Path]:
    """A place to write to, which takes the place of ``folder`` at the end.

    Raises:
        DataError: see :func:`claimable`; or the disk refuses.
    """
    target = claimable(folder)
    prefix = f".{target.name}-{_machine()}-{os.getpid()}-"
    beside = ""
    try:
        clear(target, ".partial")
        beside = tempfile.mkdtemp(prefix=prefix, suffix=".partial", dir=target.parent)
        yield Path(beside)
        Path(beside).chmod(0o755)
        if target.exists():
            aside = tempfile.mkdtemp(prefix=prefix, suffix=".old", dir=target.parent)
            target.rename(Path(aside) / "report")
            try:
                Path(beside).rename(target)
            except OSError:
                (Path(aside) / "report").rename(target)
                raise
            finally:
                shutil.rmtree(aside, ignore_errors=True)
        else:
            Path(beside).rename(target)
        # An older report that was set aside is worth keeping until a new one stands.
        clear(target, ".old")
    except OSError as error:
        raise DataError(f"{target} cannot be written: {error.strerror or error}") from None
    finally:
        if beside:
            shutil.rmtree(beside, ignore_errors=True)


def _machine() -> str:
    return re.sub(r"[^\w.]+", "_", socket.gethostname()) or "machine"


def clear(target: Path, suffix: str) -> None:
    """Removes what processes of this machine that are dead left beside a place."""
    form = re.compile(rf"\.{re.escape(target.name)}-{re.escape(_machine())}-(\d+)-[^-]*{re.escape(suffix)}")
    for left in target.parent.iterdir():
        named = form.fullmatch(left.name)
        if named and left.is_dir() and not left.is_symlink() and _dead(int(named[1])):
            shutil.rmtree(left, ignore_errors=True)


def _dead(process: int) -> bool:
    if os.name != "posix":
        return False  # there signal 0 is no question
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        return False
    return False
