"""Where compiled modules lie: in the user's cache directory, private, bounded, whole or not at all.

Machine code is loaded only from a folder and from files that nobody else can write, and only if its last 32 bytes are
the HMAC-SHA256 of the rest under a key of this folder: what another program put there is compiled anew.
"""

from __future__ import annotations

import atexit
import hashlib
import hmac
import os
import shutil
import sys
import tempfile
import warnings
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from leadscrew.util.frames import warning_level
from leadscrew.util.system import is_private, may_be_replaced, read_private

LIMIT = 5000
"""Files of modules kept, some 100 MB: more than the five studies compile; beyond, the oldest go."""
KEY = "key"
_fallback: Path | None = None
_told: set[str] = set()


@lru_cache(maxsize=1)
def stamp() -> str:
    """The versions that compiled code depends on: library, Python, LLVM."""
    from importlib.metadata import version

    from leadscrew._version import __version__

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
    """The directory for these versions, created private; a temporary one if that fails or others can write there."""
    global _fallback
    if _fallback is not None:
        return _fallback
    wanted = root() / stamp()
    try:
        wanted.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not is_private(wanted.stat()) or may_be_replaced(wanted.parent.stat()):
            problem = "can be written by other users, who could put their own machine code there"
        else:
            with tempfile.TemporaryFile(dir=wanted):
                return wanted
    except OSError as error:
        problem = f"cannot be written ({error.strerror or error})"
    _fallback = Path(tempfile.mkdtemp(prefix="leadscrew-"))
    atexit.register(shutil.rmtree, _fallback, ignore_errors=True)
    _warn(f"the cache directory {wanted} {problem}; compiled loops go to {_fallback} for this session; set "
          "LEADSCREW_CACHE_DIR to a directory of yours")  # fmt: skip
    return _fallback


def _warn(text: str) -> None:
    if text not in _told:
        _told.add(text)
        warnings.warn(text, stacklevel=warning_level())


def _put(folder: Path, name: str, data: bytes) -> None:
    """Writes a file beside its place and renames it."""
    handle, beside = tempfile.mkstemp(dir=folder, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as out:
            out.write(data)
        Path(beside).replace(folder / name)
    except OSError:
        Path(beside).unlink(missing_ok=True)
        raise


@lru_cache(maxsize=4)
def _key(folder: Path) -> bytes:
    """The secret of a cache folder, made where there is none that is whole and private."""
    for _ in range(2):
        key = read_private(folder / KEY)
        if key is not None and len(key) == 32:
            return key
        with suppress(OSError):
            _put(folder, KEY, os.urandom(32))
    return os.urandom(32)


def _mark(folder: Path, name: str, code: bytes) -> bytes:
    return hmac.digest(_key(folder), f"{name}\n".encode() + code, "sha256")


def read(name: str) -> bytes | None:
    """A file of the cache, if it is there, private and whole, and was written under this name."""
    folder = directory()
    data = read_private(folder / name)
    if data is None:
        return None
    code, mark = data[:-32], data[-32:]
    return code if hmac.compare_digest(_mark(folder, name, code), mark) else None


def write(name: str, code: bytes) -> bool:
    """Puts a file into the cache, written beside and renamed; False, with one warning, where the disk takes no more."""
    folder = directory()
    try:
        _evict(folder)
        if (folder / name).is_dir() and not (folder / name).is_symlink():
            shutil.rmtree(folder / name)
        _put(folder, name, code + _mark(folder, name, code))
    except OSError as error:
        _warn(f"the cache {folder} takes no more files ({error.strerror or error}); what is compiled now is not kept")
        return False
    return True


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
    _key.cache_clear()
    return before
