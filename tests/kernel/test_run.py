"""Saved runs: whole or not there, and what they hold."""

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

from leadscrew.kernel.loop import Loop
from leadscrew.kernel.run import load
from leadscrew.util.errors import DataError, ValueRefused
from tests.kernel import zoo

LOOP = {"reference": zoo.sine, "controller": zoo.history, "plant": zoo.mass, "metrics": {}, "name": "saved"}


def test_a_saved_run_comes_back_with_every_bit_and_its_manifest(tmp_path):
    run = Loop(**LOOP, bound=50.0).run(0.1, every=3, replicate=4)
    folder = run.save(tmp_path / "a" / "run")
    manifest, signals = load(folder)
    assert set(signals) == set(run.signals)
    for name, values in signals.items():
        assert np.array_equal(values, run.signals[name])
    assert manifest["parameters"]["controller.weights"] == [0.4, 0.3, 0.2, 0.1]
    assert manifest["replicate"] == 4 and manifest["every"] == 3 and manifest["schema_version"] == 1
    assert manifest["engine"] == "llvm" and manifest["blocks"]["plant"] == "mass" and manifest["bound"] == 50.0
    assert load(folder / "run.json")[0] == manifest
    with pytest.raises(DataError, match="exists already"):
        run.save(folder)
    assert sorted(p.name for p in folder.iterdir()) == ["run.json", "signals.parquet"]


def test_the_old_name_of_the_noise_stream_is_refused_with_the_new_one():
    loop = Loop(**LOOP)
    for call in (lambda: loop.run(0.1, run=3), lambda: loop.start(run=3)):
        with pytest.raises(ValueRefused, match="write replicate=3"):
            call()


def test_an_infinite_parameter_survives_the_manifest(tmp_path):
    run = Loop(**{**LOOP, "controller": zoo.observed}).using({"controller.plant_gain": float("inf")})
    with pytest.warns(UserWarning):
        folder = run.run(0.01).save(tmp_path / "x")
    assert "Infinity" not in (folder / "run.json").read_text()
    assert load(folder)[0]["parameters"]["controller.plant_gain"] == float("inf")


def test_a_diverged_run_can_be_saved(tmp_path):
    with pytest.warns(UserWarning):
        run = Loop(**{**LOOP, "controller": zoo.pid(kp=1e6)}).run(20.0)
    manifest, signals = load(run.save(tmp_path / "lost"))
    assert manifest["diverged"]["state"] and len(signals["time"]) == manifest["diverged"]["period"] + 1


def test_what_is_no_run_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"run\.json is missing"):
        load(tmp_path)
    run = Loop(**LOOP).run(0.01)
    folder = run.save(tmp_path / "x")
    text = (folder / "run.json").read_text()
    (folder / "run.json").write_text(text.replace('"schema_version": 1', '"schema_version": 99'))
    with pytest.raises(DataError, match="schema_version = 99"):
        load(folder)
    (folder / "run.json").write_text("{")
    with pytest.raises(DataError, match="is not JSON"):
        load(folder)
    (tmp_path / "file").write_text("")
    with pytest.raises(DataError, match=r"cannot be written|exists already"):
        run.save(tmp_path / "file" / "below")
    partial = tmp_path / ".y-123.partial"
    partial.mkdir()
    with pytest.raises(DataError, match="cut off"):
        load(partial)


def test_a_write_that_fails_leaves_nothing(tmp_path, monkeypatch):
    run = Loop(**LOOP).run(0.01)

    def full(*_args, **_more):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(json, "dumps", full)
    with pytest.raises(DataError, match="No space left"):
        run.save(tmp_path / "x")
    assert list(tmp_path.iterdir()) == []

    def stop(*_args, **_more):
        raise KeyboardInterrupt

    monkeypatch.setattr(json, "dumps", stop)
    with pytest.raises(KeyboardInterrupt):
        run.save(tmp_path / "x")
    assert list(tmp_path.iterdir()) == []


KILLED = textwrap.dedent(
    """
    import sys
    sys.path.insert(0, {root!r})
    from leadscrew.kernel.loop import Loop
    from tests.kernel import zoo
    run = Loop(reference=zoo.sine, controller=zoo.pid, plant=zoo.mass, metrics={{}}).run(5.0)
    print("ready", flush=True)
    k = 0
    while True:
        run.save({folder!r} + "/run%d" % k)
        k += 1
    """
)


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="posix: no SIGKILL")
def test_a_killed_run_leaves_no_half_folder_that_passes_for_a_whole_one(tmp_path):
    root = str(Path(__file__).parents[2])
    for delay in (0.05, 0.11, 0.2):
        folder = tmp_path / str(delay)
        folder.mkdir()
        with subprocess.Popen(
            [sys.executable, "-c", KILLED.format(root=root, folder=str(folder))], stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None and process.stdout.readline() == "ready\n"
            time.sleep(delay)
            os.kill(process.pid, signal.SIGKILL)
        for found in folder.iterdir():
            if found.name.startswith("."):
                with pytest.raises(DataError):
                    load(found)
            else:
                assert len(load(found)[1]["time"]) == 5000
