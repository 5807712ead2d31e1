"""Where compiled modules lie: in the user's cache directory, private, bounded, whole or not at all."""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

LIMIT = 5000
"""Files of modules kept, some 100 MB: more than the five studies compile; beyond, the oldest go."""
_fallback: Path | None = None


@lru_cache(maxsize=1)
def stamp() -> str:
    """The versions that compiled code depends on: library, Python, LLVM."""
    from importlib.metadata import version

    from leadscrew import __version__

    return f"{__version__}-py{sys.version_info.major}.{sys.version_info.minor}-llvmlite{version('llvmlite')}"


@lru_cache(maxsize=1)
def sources() -> str:
    """The hash of every file of the kernel: of all that turns a step into machine code."""
    here = Path(__file__).parent
    found = hashlib.sha256()
    for file in sorted(here.rglob("*.py")):
        found.update(f"{file.relative_to(here).as_posix()}\n".encode() + file.read_bytes())
    return found.hexdigest()[:16]


def root() -> Path:
    """The cache directory; ``LEADSCREW_CACHE_DIR`` sets it."""
    chosen = os.environ.get("LEADSCREW_CACHE_DIR")
    if chosen:
        return Path(chosen)
    from platformdirs import user_cache_path

    return user_cache_path("leadscrew", appauthor=False)


def directory() -> Path:
    """The directory for these versions, created private; a temporary one if that fails."""
    global _fallback
    if _fallback is not None:
        return _fallback
    wanted = root() / stamp()
    try:
        wanted.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=wanted):
            return wanted
    except OSError as error:
        _fallback = Path(tempfile.mkdtemp(prefix="leadscrew-"))
        warnings.warn(
            f"the cache directory {wanted} cannot be written ({error.strerror or error}); compiled loops go to "
            f"{_fallback} for this session; set LEADSCREW_CACHE_DIR to a directory that can",
            stacklevel=2,
        )
        return _fallback


def read(name: str) -> bytes | None:
    """A file of the cache, if it is there and whole: its last 32 bytes are the hash of the rest."""
    try:
        data = (directory() / name).read_bytes()
    except OSError:
        return None
    code, mark = data[:-32], data[-32:]
    return code if hashlib.sha256(code).digest() == mark else None


def write(name: str, code: bytes) -> None:
    """Puts a file into the cache, written beside and renamed."""
    folder = directory()
    _evict(folder)
    handle, beside = tempfile.mkstemp(dir=folder, suffix=".tmp")
    with os.fdopen(handle, "wb") as out:
        out.write(code + hashlib.sha256(code).digest())
    Path(beside).replace(folder / name)


def _evict(folder: Path) -> None:
    def age(path: Path) -> float:
        try:
            return path.stat().st_mtime
        except OSError:  # another process was faster
            return 0.0

    kept = (".o", ".so", ".npy")
    with os.scandir(folder) as entries:
        modules = [folder / e.name for e in entries if "_" in e.name and e.name.endswith(kept)]
    too_many = len(modules) - LIMIT + 1
    for path in sorted(modules, key=age)[:too_many] if too_many > 0 else ():
        path.unlink(missing_ok=True)


@dataclass(frozen=True)
class CacheInfo:
    """What lies in the cache."""

    folder: str
    modules: int
    bytes: int


def info() -> CacheInfo:
    """What lies in the cache, all versions together."""
    base = root()
    files = [p for p in base.rglob("*") if p.is_file()] if base.exists() else []
    modules = [p for p in files if p.name.startswith(("loop_", "fuzzy_")) and p.suffix in (".o", ".so")]
    return CacheInfo(str(base), len(modules), sum(p.stat().st_size for p in files))


def clear() -> CacheInfo:
    """Deletes the cache's own folders; returns what was there."""
    before = info()
    base = root()
    for folder in base.glob("*-py*-llvmlite*") if base.exists() else ():
        shutil.rmtree(folder, ignore_errors=True)
    return before
