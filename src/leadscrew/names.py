"""What a name looks like: ``path/file.py:name``, the file of a fuzzy system, a file in TOML, or a plain name.

Nothing is opened here. A name that a file gives keeps that file's path (:class:`FromFile`): Python that it names
runs by the rule of :mod:`leadscrew.userfile`.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Self

from leadscrew.util.errors import DataError

_REFERENCE = re.compile(r"(?P<path>.*\.(?:py|(?i:fis|fll|fcl|fml|xml)|toml))(?::(?P<name>[^:/\\]*))?", re.DOTALL)


class FromFile(str):
    """A name that a file gives; :func:`absolute`, copies and pickles keep the mark, methods of ``str`` do not."""

    file: str

    def __new__(cls, name: str, file: str = "") -> Self:
        made = super().__new__(cls, name)
        made.file = file
        return made


def from_file(name: str, file: Path) -> FromFile:
    """The name as ``file`` gives it: absolute, with its path looked for beside the file."""
    return FromFile(absolute(name, file.resolve().parent), str(file))


def parts(reference: str) -> tuple[Path, str | None]:
    """Path and object of ``path/file.py:name``.

    Raises:
        DataError: the name is of another form.
    """
    match = _REFERENCE.fullmatch(reference)
    if match is None:
        raise DataError(f"{reference!r}: expected path/file.py:name")
    return Path(match["path"]), match["name"]


def is_reference(text: str) -> bool:
    """Whether a name means an object in a file; a controller's name may mean a controller file besides."""
    return _REFERENCE.fullmatch(text) is not None and not is_toml(text)


def absolute(reference: str, folder: Path | None = None) -> str:
    """The reference with its path made absolute, from ``folder`` or the working directory; other names unchanged.

    The mark of a name that a file gives is kept.
    """
    found = _REFERENCE.fullmatch(reference)
    if found is None:
        return reference
    try:
        path = ((folder or Path()) / Path(found["path"]).expanduser()).resolve()
    except (OSError, RuntimeError, ValueError):  # whoever opens it says what is wrong
        return reference
    made = f"{path}:{found['name']}" if found["name"] else str(path)
    return FromFile(made, reference.file) if isinstance(reference, FromFile) else made


def is_fuzzy_file(reference: str) -> bool:
    """Whether a name means a file that is not Python: a fuzzy system."""
    found = _REFERENCE.fullmatch(reference)
    return found is not None and not found["path"].endswith((".py", ".toml"))


def is_toml(reference: str) -> bool:
    """Whether a name means a file in TOML: a machine, an experiment, or a controller."""
    return reference.endswith(".toml")


def stem(reference: str) -> str:
    """What is made of a controller of this name is called: as the object is, or as the file that is not Python."""
    if is_fuzzy_file(reference) or is_toml(reference):
        return re.sub(r"\W", "_", parts(reference)[0].stem)
    return reference.rsplit(":", 1)[-1].rsplit(".", 1)[-1]
