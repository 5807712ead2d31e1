"""The signals of a session that was run again, with the session, in a folder that appears only when complete."""

from __future__ import annotations

from pathlib import Path

from leadscrew.kernel.errors import ValueRefused
from leadscrew.newfolder import appearing
from leadscrew.operate import session_file
from leadscrew.operate.session import Rerun, Session


def check(folder: Path) -> None:
    """The folder can be written.

    Raises:
        ValueRefused: it is there and not empty.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueRefused(f"--out {folder} exists already; choose another folder or remove it")


def write(session: Session, rerun: Rerun, folder: Path) -> None:
    """Writes ``signals.parquet`` and ``session.toml``.

    Raises:
        DataError: it cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    with appearing(folder) as beside:
        pq.write_table(pa.table({k: pa.array(v) for k, v in rerun.signals.items()}), beside / "signals.parquet")
        session_file.write(session, beside / "session.toml")


__all__ = ["check", "write"]
