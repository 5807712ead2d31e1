"""Files and folders that appear whole or not at all."""

import os
import signal
import socket
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from leadscrew.util import atomic, system
from leadscrew.util.atomic import atomic_folder, atomic_write, replace_folder
from leadscrew.util.errors import DataError


def names(folder):
    return sorted(p.name for p in folder.rglob("*"))


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.parametrize("durable", [True, False])
def test_a_file_is_saved_with_its_lines_as_given_and_replaces_an_older_one(tmp_path, durable):
    for data, expected in (("a\r\nµ\n", b"a\r\n\xc2\xb5\n"), (b"\x00\xff", b"\x00\xff")):
        atomic_write(data, tmp_path / "new" / "x.txt", durable)
        assert (tmp_path / "new" / "x.txt").read_bytes() == expected
    assert names(tmp_path) == ["new", "x.txt"] and mode(tmp_path / "new" / "x.txt") == 0o644


def test_a_file_that_cannot_be_put_in_its_place_leaves_nothing_beside_it(tmp_path):
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "kept").write_text("")
    with pytest.raises(DataError, match="x cannot be written: Is a directory"):
        atomic_write("data", tmp_path / "x")
    with pytest.raises(DataError, match="cannot be written"):
        atomic_write("data", tmp_path / "x" / "kept" / "below")
    assert names(tmp_path) == ["kept", "x"]


def test_a_folder_appears_at_the_end_for_all_to_read(tmp_path):
    for name in ("new", "empty"):
        if name == "empty":
            (tmp_path / name).mkdir()
        with atomic_folder(tmp_path / name) as place:
            (place / "a").write_text("1")
            assert not (tmp_path / name / "a").exists()
        assert names(tmp_path / name) == ["a"] and mode(tmp_path / name) == 0o755


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), ValueError("no"), KeyboardInterrupt()])
def test_a_folder_whose_writing_ends_early_leaves_nothing(tmp_path, error):
    with pytest.raises((DataError, type(error))) as seen, atomic_folder(tmp_path / "out") as place:
        (place / "a").write_text("1")
        raise error
    assert names(tmp_path) == []
    if isinstance(error, OSError):
        assert "out cannot be written: No space left on device" in str(seen.value)


def test_a_folder_with_something_in_it_is_not_written_over(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "kept").write_text("1")
    for target in ("out", "out/kept"):
        with pytest.raises(DataError, match="exists already"), atomic_folder(tmp_path / target):
            pass
    with pytest.raises(DataError, match="kept is not a folder"), atomic_folder(tmp_path / "out" / "kept" / "below"):
        pass
    assert names(tmp_path) == ["kept", "out"]


def test_a_folder_that_others_fill_meanwhile_is_not_replaced(tmp_path):
    def made(folder):
        return replace_folder(folder, lambda f: names(f) == ["ours"], "ours")

    for new in (atomic_folder, made):
        with pytest.raises(DataError, match=r"exists already|holds something"), new(tmp_path / "out") as place:
            (place / "a").write_text("1")
            (tmp_path / "out").mkdir(exist_ok=True)
            (tmp_path / "out" / "kept").write_text("1")
        assert names(tmp_path) == ["kept", "out"]
        (tmp_path / "out" / "kept").unlink()


def test_an_older_folder_comes_back_where_the_new_one_cannot_take_its_place(tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "old").write_text("1")
    rename = Path.rename

    def fails(self, target):
        if self.suffix == ".partial":
            raise OSError(28, "No space left on device")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fails)
    with pytest.raises(DataError, match="No space left"), replace_folder(tmp_path / "out", lambda f: True, "ours"):
        pass
    assert names(tmp_path) == ["old", "out"]


# ---- modes
@pytest.fixture(params=[0o022, 0o077, 0o002, 0o027])
def umask(request):
    before = os.umask(request.param)
    yield request.param
    os.umask(before)


def test_new_files_and_folders_have_the_modes_that_the_umask_leaves(tmp_path, umask):
    atomic_write("data", tmp_path / "x" / "a.txt")
    with atomic_folder(tmp_path / "out") as place:
        (place / "a").write_text("1")
    with replace_folder(tmp_path / "report", lambda folder: True, "ours") as place:
        (place / "a").write_text("1")
    assert mode(tmp_path / "x" / "a.txt") == 0o666 & ~umask
    assert mode(tmp_path / "out") == mode(tmp_path / "report") == 0o777 & ~umask


def test_what_is_replaced_keeps_its_mode(tmp_path):
    for kept in (0o600, 0o640, 0o664, 0o444):
        atomic_write("old", tmp_path / "a.txt")
        (tmp_path / "a.txt").chmod(kept)
        atomic_write("new", tmp_path / "a.txt")
        assert mode(tmp_path / "a.txt") == kept and (tmp_path / "a.txt").read_text() == "new"
    (tmp_path / "out").mkdir(0o700)
    with atomic_folder(tmp_path / "out") as place:
        assert mode(place) == 0o700
        (place / "old").write_text("1")
    with replace_folder(tmp_path / "out", lambda folder: True, "ours") as place:
        (place / "new").write_text("1")
    assert mode(tmp_path / "out") == 0o700 and names(tmp_path / "out") == ["new"]


def test_a_private_file_is_private_while_it_is_replaced(tmp_path, monkeypatch):
    atomic_write("old", tmp_path / "a.txt")
    (tmp_path / "a.txt").chmod(0o600)
    seen = []
    monkeypatch.setattr(os, "fsync", lambda handle: seen.append(stat.S_IMODE(os.fstat(handle).st_mode)))
    atomic_write("new", tmp_path / "a.txt")
    assert seen[0] == 0o600


# ---- links and devices
def test_through_a_link_its_file_or_folder_is_written_and_the_link_stays(tmp_path):
    far = tmp_path / "far"
    (far / "folder").mkdir(parents=True)
    (far / "a.txt").write_text("old")
    for link, end in (("a.txt", "far/a.txt"), ("second", "a.txt"), ("folder", far / "folder")):
        (tmp_path / link).symlink_to(end)
    atomic_write("new", tmp_path / "second")
    with atomic_folder(tmp_path / "folder") as place:
        (place / "b").write_text("1")
    assert all((tmp_path / link).is_symlink() for link in ("a.txt", "second", "folder"))
    assert (far / "a.txt").read_text() == "new" and names(far) == ["a.txt", "b", "folder"]
    with replace_folder(tmp_path / "folder", lambda folder: True, "ours") as place:
        (place / "c").write_text("1")
    assert (tmp_path / "folder").is_symlink() and names(far) == ["a.txt", "c", "folder"]


def test_a_link_to_nothing_is_refused_in_a_sentence(tmp_path):
    (tmp_path / "link").symlink_to("nowhere")
    (tmp_path / "round").symlink_to("round")
    says = "link is a link to nowhere, which does not exist; make nowhere, or remove the link"
    with pytest.raises(DataError, match=says):
        atomic_write("data", tmp_path / "link")
    for made in (atomic_folder, lambda folder: replace_folder(folder, lambda f: True, "ours")):
        with pytest.raises(DataError, match=says), made(tmp_path / "link"):
            pass
        with pytest.raises(DataError, match="round cannot be written: "), made(tmp_path / "round"):
            pass
    assert names(tmp_path) == ["link", "round"]


def test_a_pipe_is_written_to_and_stays_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    heard = []
    reader = threading.Thread(target=lambda: heard.append((tmp_path / "pipe").read_bytes()))
    reader.start()
    atomic_write("data", tmp_path / "pipe")
    reader.join()
    assert heard == [b"data"] and stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_text_that_is_no_unicode_is_refused_and_leaves_nothing(tmp_path):
    with pytest.raises(DataError, match=r"a\.txt cannot be written: a name or note in it is no Unicode text"):
        atomic_write("\udc80", tmp_path / "a.txt")
    assert names(tmp_path) == []


# ---- what killed processes leave
KILL = """
import os, signal, sys, time
from leadscrew.util import atomic

def end(*_):
    print("written", flush=True)
    if sys.argv[2] == "wait":
        time.sleep(60)
    os.kill(os.getpid(), signal.SIGKILL)

if sys.argv[1].endswith("txt"):
    os.fsync = end
    atomic.atomic_write("half", sys.argv[1])
with atomic.atomic_folder(sys.argv[1]) as place:
    (place / "half").write_text("half")
    end()
"""


@pytest.mark.parametrize("name", ["a.txt", "out"])
def test_what_a_killed_process_left_is_removed_by_the_next_that_writes_to_the_folder(tmp_path, name):
    done = subprocess.run([sys.executable, "-c", KILL, tmp_path / name, "kill"], stdout=subprocess.PIPE, check=False)
    assert done.returncode == -signal.SIGKILL
    (left,) = tmp_path.iterdir()
    assert left.name.startswith(f".{name}-") and left.suffix in (".tmp", ".partial")
    atomic_write("data", tmp_path / "b.txt")
    assert names(tmp_path) == ["b.txt"]


def test_what_a_process_is_writing_stays(tmp_path):
    command = [sys.executable, "-c", KILL, tmp_path / "out", "wait"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as running:
        try:
            assert running.stdout.readline() == b"written\n"
            atomic_write("data", tmp_path / "b.txt")
            assert len(list(tmp_path.iterdir())) == 2
        finally:
            running.kill()


def test_files_of_the_user_of_other_hosts_and_under_a_lock_stay(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    ours = f"{atomic._host()}-{dead.pid}-0123abcd"
    kept = [
        f".a-elsewhere-{dead.pid}-0123abcd.tmp", f".a-{atomic._host()}-{os.getpid()}-0123abcd.tmp",
        ".a-0123abcd.tmp",
        f".a-{ours}.txt", f"a-{ours}.tmp", f".a-{ours}.old", f".locked-{ours}.tmp", f".link-{ours}.tmp",
        f".a-{atomic._host()}-{dead.pid}-0123ABCD.tmp", f".folder-{ours}.tmp", f".a-{ours}x.tmp",
    ]  # fmt: skip
    for name in kept:
        if "link" in name:
            (tmp_path / name).symlink_to("a")
        elif "folder" in name:
            (tmp_path / name).mkdir()
        else:
            (tmp_path / name).write_text("mine")
    (tmp_path / f".gone-{ours}.tmp").write_text("half")
    (tmp_path / f".gone-{ours}.partial").mkdir()
    with (tmp_path / f".locked-{ours}.tmp").open("rb") as locked:
        system.lock(locked.fileno())
        atomic_write("data", tmp_path / "b.txt")
    assert set(names(tmp_path)) == {"b.txt", *kept}


def test_what_was_set_aside_stays_until_a_new_folder_stands(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    aside = tmp_path / f".out-{atomic._host()}-{dead.pid}-0123abcd.old"
    (aside / "out").mkdir(parents=True)
    with pytest.raises(ValueError), replace_folder(tmp_path / "out", lambda f: True, "ours"):
        raise ValueError
    assert aside.exists()
    with replace_folder(tmp_path / "out", lambda f: True, "ours") as place:
        (place / "a").write_text("1")
    assert names(tmp_path) == ["a", "out"]


def test_a_long_name_and_a_host_with_dashes_fit(tmp_path, monkeypatch):
    monkeypatch.setattr(socket, "gethostname", lambda: "mill-3.works-" + 200 * "x")
    for name in ("n" * 255, "ü" * 127):
        atomic_write("data", tmp_path / name)
        assert (tmp_path / name).exists()
    assert system.is_running(os.getpid()) and not system.is_running(2**40)


def test_without_what_posix_systems_have_files_and_folders_are_written(tmp_path):
    """As on Windows: no fcntl and no resource, no owners, and a signal 0 that ends the process."""
    code = """
import os, sys
sys.modules["fcntl"] = sys.modules["resource"] = None
for name in ("geteuid", "getuid", "fchmod", "killpg", "O_NOFOLLOW", "O_NONBLOCK"):
    delattr(os, name)
os.kill = lambda *_: os._exit(3)
from leadscrew.util import atomic
from leadscrew.kernel import cache
from leadscrew.util import system
from leadscrew.tune import executors
atomic.atomic_write("data", "a.txt")
with atomic.atomic_folder("out") as place:
    (place / "b").write_text("1")
with atomic.replace_folder("out", lambda folder: True, "ours") as place:
    (place / "c").write_text("1")
assert system.is_running(1) and not system.is_locked("a.txt") and system.peak_memory() is None
assert system.is_own(os.stat("/")) and system.is_private(os.stat("a.txt"))
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, check=True)
    assert names(tmp_path) == ["a.txt", "c", "out"]
