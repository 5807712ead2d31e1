"""Results on disk as they come, so that a job that was killed goes on where it was.

A folder with ``question.json`` (what is asked, and its hash) and one file a chunk. Every file is written beside and
renamed: whatever ends the process, one that is there is whole. Chunks are not forced to the disk: one that a power cut
tore is as good as none, and is done again. Another question in the same folder is refused, unless no chunk of it is
done: a journal without any is in nobody's way.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from leadscrew.util import reading
from leadscrew.util.atomic import atomic_write
from leadscrew.util.errors import DataError, ValueRefused

QUESTION = "question.json"
CHUNKS = "chunk_*.npz"


def mark(question: Mapping[str, Any]) -> str:
    """The hash of a question."""
    return hashlib.sha256(json.dumps(question, sort_keys=True, default=str).encode()).hexdigest()


class Journal:
    """The results of a job by number of their chunk."""

    def __init__(self, folder: str | Path, question: Mapping[str, Any], resume: bool = False) -> None:
        """Opens or begins a journal.

        Raises:
            ValueRefused: there is one already and ``resume`` is not asked for, or of another question.
            DataError: it cannot be read or written.
        """
        self.folder = Path(folder)
        at = self.folder / QUESTION
        if at.exists() and self.chunks:
            self._check(self._read(at), question, resume)
        elif self.folder.exists() and any(p.name != QUESTION and p.name[0] != "." for p in self.folder.iterdir()):
            raise ValueRefused(f"{self.folder} is there already and holds something else; choose another folder")
        else:
            said = {"schema_version": 1, "hash": mark(question), "question": _plain(dict(question))}
            atomic_write(json.dumps(said, indent=1) + "\n", at)
        for left in self._torn():
            left.unlink(missing_ok=True)

    def _check(self, kept: Mapping[str, Any], question: Mapping[str, Any], resume: bool) -> None:
        if kept.get("hash") != mark(question):
            other = ", ".join(k for k in question if kept.get("question", {}).get(k) != _plain(question[k]))
            raise ValueRefused(
                f"{self.folder} holds the results of another question"
                f"{f' (different: {other})' if other else ''}; remove it, or choose another folder"
            )
        if not resume:
            raise ValueRefused(f"{self.folder} holds results of this question already: --resume goes on with them")

    @property
    def chunks(self) -> int:
        """How many are done."""
        return sum(1 for _ in self.folder.glob(CHUNKS))

    def remove(self) -> None:
        """Takes away what this journal wrote, and the folder if nothing else is in it."""
        with contextlib.suppress(OSError):
            for path in (*self._torn(), *self.folder.glob(CHUNKS), self.folder / QUESTION):
                path.unlink(missing_ok=True)
            self.folder.rmdir()

    def _torn(self) -> list[Path]:
        """What a killed process was writing."""
        return [path for name in (QUESTION, CHUNKS) for path in self.folder.glob(f".{name}-*.tmp")]

    @staticmethod
    def _read(path: Path) -> dict[str, Any]:
        return reading.json_object(path)

    def path(self, number: int) -> Path:
        """The file of a chunk."""
        return self.folder / f"chunk_{number:07d}.npz"

    def get(self, number: int) -> dict[str, np.ndarray] | None:
        """The result of a chunk, if it is there; a file that is torn counts as none.

        Raises:
            DataError: it is there and may not be read.
        """
        try:
            with np.load(self.path(number)) as found:
                if any(part.compress_type != zipfile.ZIP_STORED for part in found.zip.infolist()):
                    return None  # never ours: it could stand for any size
                return {k: found[k] for k in found.files}
        except (FileNotFoundError, ValueError, EOFError, KeyError, AttributeError, zipfile.BadZipFile, zlib.error):
            return None
        except (MemoryError, NotImplementedError, RuntimeError):  # broken in its header, or encrypted
            return None
        except OSError as error:
            raise DataError(f"{self.path(number)} cannot be read: {error.strerror or error}") from None

    def put(self, number: int, result: Mapping[str, np.ndarray]) -> None:
        """Keeps the result of a chunk.

        Raises:
            DataError: it cannot be written (a full disk): what was there before is still there.
        """
        held = io.BytesIO()
        columns: dict[str, Any] = dict(result)
        np.savez(held, **columns)
        atomic_write(held.getvalue(), self.path(number), durable=False)


def _plain(value: Any) -> Any:
    return json.loads(json.dumps(value, default=str))
