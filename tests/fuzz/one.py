"""One changed file before one reader: it is read, or refused in a sentence."""

from __future__ import annotations

import os
import random
import shutil
import warnings
from functools import cache
from pathlib import Path

from leadscrew.util.errors import LeadscrewError
from tests.fuzz.mutate import mutated
from tests.fuzz.targets import Target, targets


@cache
def _files() -> list[bytes]:
    return [path.read_bytes() for target in targets() for path in target.seeds]


def made(target: Target, seed: int, folder: Path) -> Path:
    """The changed file number ``seed`` of a target, in ``folder``."""
    rng = random.Random(f"{target.name} {seed}")
    whole = rng.choice(target.seeds)
    if target.folder is not None:
        for path in target.folder.iterdir():
            shutil.copy(path, folder / path.name)
    changed = folder / whole.name
    changed.write_bytes(mutated(whole.read_bytes(), rng, _files()))
    return changed


def tried(target: Target, path: Path) -> str:
    """What the reader says of the file.

    Raises:
        AssertionError: it refused without a sentence.
        Exception: whatever escaped from it.
    """
    before = Path.cwd()
    os.chdir(path.parent)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _command(target.work, path, target) if isinstance(target.work, str) else _function(target, path)
    finally:
        os.chdir(before)


def _function(target: Target, path: Path) -> str:
    try:
        target.work(path)  # type: ignore[operator]
    except LeadscrewError as refused:
        assert str(refused).strip()
        return "refused"
    return "read"


@cache
def _app():
    import typer

    from leadscrew.cli import app

    return typer.main.get_command(app)


def _command(words: str, path: Path, target: Target) -> str:
    from click.testing import CliRunner

    name = path.parent if target.folder is not None else path
    done = CliRunner().invoke(_app(), [str(name) if word == "@" else word for word in words.split()])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code in (0, 1, 2, 3), done.output
    if done.exit_code == 2:
        assert "leadscrew: " in done.output or "refused: " in done.output or '"refused"' in done.output, done.output
    return "refused" if done.exit_code else "read"
