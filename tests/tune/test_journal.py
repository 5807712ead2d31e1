"""A journal: whole or not there, of one question, and what it refuses."""

from __future__ import annotations

import errno
import os

import numpy as np
import pytest

from leadscrew.tune.checkpoints import Journal
from leadscrew.tune.executors import Threads
from leadscrew.tune.montecarlo import montecarlo, question
from leadscrew.tune.space import Space
from leadscrew.util import atomic
from leadscrew.util.errors import DataError, ValueRefused
from tests.tune.shared import job, same

SPACE = Space.of(["plant.lag_s=0.02:0.08"])
ASKED = {"kind": "test", "runs": 3, "over": ["a=1:2"]}


def test_what_is_put_is_got(tmp_path):
    journal = Journal(tmp_path / "j", ASKED)
    result = {"m": np.array([1.0, np.nan]), "diverged_at": np.array([np.nan, 0.1])}
    assert journal.get(0) is None
    journal.put(0, result)
    again = Journal(tmp_path / "j", ASKED, resume=True).get(0)
    assert all(again[k].tobytes() == v.tobytes() for k, v in result.items())


def test_another_question_is_refused_and_named(tmp_path):
    Journal(tmp_path / "j", ASKED).put(0, {"m": np.arange(3.0)})
    for resume in (True, False):
        with pytest.raises(ValueRefused, match=r"another question \(different: runs\); remove it, or choose another"):
            Journal(tmp_path / "j", {**ASKED, "runs": 4}, resume)
    with pytest.raises(ValueRefused, match="--resume"):
        Journal(tmp_path / "j", ASKED)


def test_a_journal_without_any_chunk_is_in_nobodys_way(tmp_path):
    Journal(tmp_path / "j", ASKED)
    (tmp_path / "j" / "question.json").write_text("{")
    journal = Journal(tmp_path / "j", {**ASKED, "runs": 4})
    assert journal.chunks == 0
    journal.put(0, {"m": np.arange(3.0)})
    assert Journal(tmp_path / "j", {**ASKED, "runs": 4}, resume=True).chunks == 1
    with pytest.raises(ValueRefused, match="another question"):
        Journal(tmp_path / "j", ASKED)


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(ValueRefused, match="holds something else"):
        Journal(tmp_path, ASKED, resume=True)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


def test_a_chunk_that_a_power_cut_tore_counts_as_none(tmp_path):
    journal = Journal(tmp_path / "j", ASKED)
    journal.put(0, {"m": np.arange(100.0)})
    whole = journal.path(0).read_bytes()
    assert journal.get(0) is not None
    flipped = whole[:300] + bytes([whole[300] ^ 1]) + whole[301:]
    for torn in (whole[:50], whole[:-60], b"", b"x" * 100, b"\0" * len(whole), flipped, whole[:200] + b"\0" * 500):
        journal.path(0).write_bytes(torn)
        assert journal.get(0) is None
    (tmp_path / "j" / "question.json").write_text("{")
    with pytest.raises(DataError, match=r"question\.json: is not JSON"):
        Journal(tmp_path / "j", ASKED, resume=True)


def test_a_job_with_torn_chunks_gives_the_identical_result(tmp_path):
    j = job(duration=2.0)
    asked = question(j, SPACE, 4000, 0, "lhs")
    whole = montecarlo(j, SPACE, 4000, crew=Threads(1), journal=Journal(tmp_path / "j", asked)).samples
    for n, keep in ((0, 0), (2, 1000)):
        path = tmp_path / "j" / f"chunk_{n:07d}.npz"
        path.write_bytes(path.read_bytes()[:keep])
    journal = Journal(tmp_path / "j", asked, resume=True)
    assert same(whole, montecarlo(j, SPACE, 4000, crew=Threads(1), journal=journal).samples)
    assert journal.get(0) is not None and journal.get(2) is not None


def test_files_are_on_the_disk_before_they_have_their_name(tmp_path, monkeypatch):
    synced: list[bool] = []
    monkeypatch.setattr(atomic.os, "fsync", lambda handle: synced.append((tmp_path / "t.toml").exists()))
    atomic.atomic_write("x", tmp_path / "t.toml")
    assert synced == [False, True], "the file before it is renamed, its folder after"
    synced.clear()
    Journal(tmp_path / "j", ASKED).put(0, {"m": np.arange(3.0)})
    assert len(synced) == 2, "the question; a chunk may be done again"


def test_what_a_killed_process_left_is_cleared(tmp_path):
    Journal(tmp_path / "j", ASKED)
    (tmp_path / "j" / ".chunk_0000000.npz-abc.tmp").write_bytes(b"half")
    Journal(tmp_path / "j", ASKED, resume=True)
    assert [p.name for p in (tmp_path / "j").iterdir()] == ["question.json"]


def test_a_full_disk_is_one_sentence_and_what_was_kept_goes_on(tmp_path, monkeypatch):
    j = job(duration=2.0)
    asked = question(j, SPACE, 4000, 0, "lhs")
    whole = montecarlo(j, SPACE, 4000, crew=Threads(1)).samples
    real, left = os.fdopen, [2]

    class Full:
        def __init__(self, handle: int) -> None:
            os.close(handle)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

        def write(self, data: bytes) -> int:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def fdopen(handle, *args, **kwargs):
        left[0] -= 1
        return real(handle, *args, **kwargs) if left[0] >= 0 else Full(handle)

    journal = Journal(tmp_path / "j", asked)
    with monkeypatch.context() as patch:
        patch.setattr(atomic.os, "fdopen", fdopen)
        with pytest.raises(DataError, match="No space left on device") as said:
            montecarlo(j, SPACE, 4000, crew=Threads(1), journal=journal)
    assert "\n" not in str(said.value)
    assert sorted(p.name for p in (tmp_path / "j").iterdir()) == [
        "chunk_0000000.npz", "chunk_0000001.npz", "question.json",
    ]  # fmt: skip
    again = montecarlo(j, SPACE, 4000, crew=Threads(2), journal=Journal(tmp_path / "j", asked, resume=True)).samples
    assert same(whole, again)


def test_only_what_is_missing_is_done_again(tmp_path):
    j = job(duration=2.0)
    journal = Journal(tmp_path / "j", question(j, SPACE, 4000, 0, "lhs"))
    seen: list[tuple[int, int]] = []
    first = montecarlo(j, SPACE, 4000, crew=Threads(2), journal=journal, progress=lambda *a: seen.append(a)).samples
    assert seen[0] == (0, 4000) and seen[-1] == (4000, 4000) and seen == sorted(seen)
    journal.path(2).unlink()
    seen.clear()
    again = montecarlo(j, SPACE, 4000, crew=Threads(1), journal=journal, progress=lambda *a: seen.append(a)).samples
    assert seen == [(2976, 4000), (4000, 4000)] and same(first, again)


def test_a_journal_that_goes_takes_nothing_with_it_that_is_not_its_own(tmp_path):
    """A folder that holds hidden files alone may become a journal: a new repository, say."""
    (tmp_path / ".git").mkdir()
    (tmp_path / ".mine.tmp").write_text("mine")
    journal = Journal(tmp_path, ASKED)
    journal.put(0, {"m": np.arange(3.0)})
    (tmp_path / ".chunk_0000001.npz-abc.tmp").write_text("torn")
    assert (tmp_path / ".mine.tmp").exists()
    journal.remove()
    assert sorted(p.name for p in tmp_path.iterdir()) == [".git", ".mine.tmp"]
    own = Journal(tmp_path / "own", ASKED)
    own.remove()
    assert not (tmp_path / "own").exists()
