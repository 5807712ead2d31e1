"""The cache: nothing compiled twice, nothing half-written, private, bounded."""

import errno
import hashlib
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import textwrap
import warnings
from pathlib import Path
from types import SimpleNamespace

import pytest

from leadscrew.kernel import cache
from leadscrew.kernel.loop import Loop
from leadscrew.kernel.program import programs
from tests.kernel import zoo
from tests.tools import missing

PROGRAM = textwrap.dedent(
    """
    import sys
    sys.path.insert(0, {root!r})
    from leadscrew.kernel.loop import Loop
    from leadscrew.kernel import lower
    from tests.kernel import zoo
    lowered = []
    real = lower.Lowering.run
    lower.Lowering.run = lambda self: (lowered.append(1), real(self))[1]
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={{}})
    loop.run(0.01)
    print(len(lowered))
    """
)


def compilations(folder: Path) -> int:
    root = str(Path(__file__).parents[2])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(root=root)], capture_output=True, text=True, check=True,
        env={**os.environ, "LEADSCREW_CACHE_DIR": str(folder)},
    )  # fmt: skip
    return int(done.stdout)


def test_a_second_process_does_not_compile_again(tmp_path):
    assert compilations(tmp_path) == 1
    before = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("loop_*") if p.is_file()}
    assert before
    assert compilations(tmp_path) == 0
    assert {p: p.stat().st_mtime_ns for p in tmp_path.rglob("loop_*") if p.is_file()} == before


@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv("LEADSCREW_CACHE_DIR", str(tmp_path / "c"))
    monkeypatch.setattr(cache, "_fallback", None)
    return tmp_path / "c"


def test_the_folder_is_private_and_its_files_whole(own):
    cache.write("loop_a.o", b"code")
    if os.name == "posix":
        assert stat.S_IMODE(cache.directory().stat().st_mode) == 0o700
    assert cache.read("loop_a.o") == b"code" and cache.read("loop_b.o") is None
    (cache.directory() / "loop_a.o").write_bytes(b"cut off")
    assert cache.read("loop_a.o") is None
    cache.write("fuzzy_a.o", b"code")
    info = cache.info()
    assert info.modules == 2 and info.bytes > 0 and info.folder == str(own)
    assert cache.clear().modules == 2 and cache.info().modules == 0


def test_the_oldest_go_when_there_are_too_many(own, monkeypatch):
    monkeypatch.setattr(cache, "LIMIT", 3)
    paths = []
    for i in range(5):
        cache.write(f"loop_{i}.o", b"code")
        paths.append(cache.directory() / f"loop_{i}.o")
        os.utime(paths[-1], (1000 + i, 1000 + i))
    assert [p.exists() for p in paths] == [False, False, True, True, True]


@pytest.mark.parametrize("suffix", ["o", "so", "npy"])
def test_compiled_files_and_tables_do_not_pile_up_either(own, monkeypatch, suffix):
    monkeypatch.setattr(cache, "LIMIT", 3)
    for i in range(5):
        cache.write(f"loop_{i}.{suffix}", b"code")
        os.utime(cache.directory() / f"loop_{i}.{suffix}", (1000 + i, 1000 + i))
    assert [cache.read(f"loop_{i}.{suffix}") for i in range(5)] == [None, None, b"code", b"code", b"code"]


def test_a_cache_that_cannot_be_written_falls_back_with_one_warning(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setenv("LEADSCREW_CACHE_DIR", str(blocked))
    monkeypatch.setattr(cache, "_fallback", None)
    with pytest.warns(UserWarning, match="set LEADSCREW_CACHE_DIR"):
        folder = cache.directory()
    assert folder != blocked and folder.is_dir()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cache.directory() == folder


def whole_but_forged(code: bytes) -> bytes:
    """A file as anybody could write it: with a hash that needs no key."""
    return code + hashlib.sha256(code).digest()


def test_machine_code_that_another_program_wrote_is_not_loaded(own):
    cache.write("loop_a.o", b"code")
    (cache.directory() / "loop_a.o").write_bytes(whole_but_forged(b"other code"))
    assert cache.read("loop_a.o") is None
    cache.write("loop_a.o", b"code")
    shutil.copy(cache.directory() / "loop_a.o", cache.directory() / "loop_b.o")
    assert cache.read("loop_a.o") == b"code" and cache.read("loop_b.o") is None
    assert len((cache.directory() / cache.KEY).read_bytes()) == 32


@pytest.mark.skipif(os.name != "posix", reason="posix: owners, modes and pipes")
@pytest.mark.parametrize("what", ["pipe", "folder", "link", "open to others"])
def test_what_is_no_private_file_is_compiled_again_and_replaced(own, what):
    cache.write("loop_a.o", b"code")
    file = cache.directory() / "loop_a.o"
    if what == "open to others":
        file.chmod(0o666)
    else:
        file.rename(own / "elsewhere")
        {"pipe": os.mkfifo, "folder": Path.mkdir, "link": lambda at: at.symlink_to(own / "elsewhere")}[what](file)
    assert cache.read("loop_a.o") is None
    assert cache.write("loop_a.o", b"code") and cache.read("loop_a.o") == b"code"


@pytest.mark.skipif(os.name != "posix", reason="posix: owners and modes")
@pytest.mark.parametrize("open_one", ["the folder", "the folder above"])
def test_a_folder_that_others_can_write_is_refused_with_one_warning(own, open_one):
    folder = cache.directory()
    (folder if open_one == "the folder" else own).chmod(0o777)
    with pytest.warns(UserWarning, match="can be written by other users"):
        assert cache.directory() != folder
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not cache.directory().is_relative_to(own)


@pytest.mark.parametrize("engine", ["llvm", pytest.param("c", marks=pytest.mark.slow)])
def test_on_a_full_disk_a_loop_still_runs_with_one_warning(own, monkeypatch, engine):
    if engine == "c" and shutil.which("gcc") is None:
        missing("gcc", "gcc is not installed")
    cache.directory()
    real = tempfile.mkstemp

    def full(*args, **options):
        if options.get("dir") == cache.directory():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real(*args, **options)

    monkeypatch.setattr(tempfile, "mkstemp", full)
    monkeypatch.setattr(cache, "_told", set())
    programs.clear()
    loop = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={})
    with pytest.warns(UserWarning, match="takes no more files") as said:
        runs = [loop.run(0.01, engine=engine), loop.using({"controller.kp": 1.0}).run(0.02, engine=engine)]
        loop.batch(0.01, {"controller.kp": [1.0, 2.0]}, engine=engine)
    assert len(said) == 1 and not any(run.diverged for run in runs)


def test_without_the_variable_it_lies_where_the_platform_says(monkeypatch):
    monkeypatch.delenv("LEADSCREW_CACHE_DIR", raising=False)
    assert cache.root().name == "leadscrew"


def test_a_change_of_any_file_of_the_kernel_compiles_anew(tmp_path, monkeypatch):
    kernel = tmp_path / "kernel"
    shutil.copytree(Path(cache.__file__).parent, kernel, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(cache, "__file__", str(kernel / "cache.py"))
    key = cache.sources.__wrapped__
    before = key()
    for file in (kernel / "module.py", kernel / "portable" / "__init__.py", kernel / "drivers" / "lanes.py"):
        text = file.read_bytes()
        file.write_bytes(text + b"\n")
        assert key() != before
        file.write_bytes(text)
    assert key() == before


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("leadscrew._version.__version__", "0.0.0"),
        ("leadscrew.kernel.cache.sys", SimpleNamespace(version_info=SimpleNamespace(major=3, minor=99))),
        ("importlib.metadata.version", lambda package: "0.0.0"),
    ],
    ids=["Leadscrew", "Python", "llvmlite"],
)
def test_machine_code_of_another_version_is_not_loaded(monkeypatch, name, other):
    before = cache.stamp.__wrapped__()
    monkeypatch.setattr(name, other)
    assert cache.stamp.__wrapped__() != before
