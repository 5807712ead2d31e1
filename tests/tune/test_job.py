"""A job: the same bits however it is cut, its mark, and what it refuses."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from leadscrew.experiment import Experiment
from leadscrew.tune.job import Chunk, Job, chunk_size, chunks_of
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.tune.shared import job, lathe


def test_a_run_has_the_same_bits_in_any_chunk_and_alone():
    j = job()
    columns = {"plant.lag_s": np.linspace(0.02, 0.08, 9), "controller.kp": np.linspace(5, 30, 9)}
    whole = j.run(Chunk("small", columns, 3))
    part = j.run(Chunk("small", {k: v[4:6].copy() for k, v in columns.items()}, 7))
    loop = j.loop("small")
    for k in (4, 5):
        alone = loop.using({key: float(v[k]) for key, v in columns.items()}).run(0.1, every=0, replicate=3 + k)
        for m in j.metrics():
            assert whole[m][k].tobytes() == part[m][k - 4].tobytes() == np.float64(alone.metrics[m]).tobytes()


def test_chunks_cover_every_run_once_and_depend_on_the_job_alone():
    j = job("small", "large", duration=2.0)
    columns = {"plant.lag_s": np.arange(1.0, 5001.0)}
    chunks = chunks_of(j, columns)
    for scenario in j.where:
        mine = [c for c in chunks if c.scenario == scenario]
        assert np.array_equal(np.concatenate([c.columns["plant.lag_s"] for c in mine]), columns["plant.lag_s"])
        assert [c.first for c in mine] == np.cumsum([0, *(c.runs for c in mine)])[:-1].tolist()
    assert chunk_size(j, "small", 5000) == 1024 and chunk_size(j, "small", 3) == 3


def test_a_job_can_be_sent_and_is_the_same_there():
    for changes in ({}, {"controller.e_centres": np.array([-1.0, -0.6, -0.3, 0.3, 0.6, 1.0])}):
        j = Job(Experiment("vud_lathe", "corrected.vud_beta_e", changes=changes), ("fig11a_step_m50",), 0.2)
        sent = pickle.loads(pickle.dumps(j))
        assert (
            sent == j and hash(sent) == hash(j) and sent.mark == j.mark and sent.loop(j.where[0]) is j.loop(j.where[0])
        )
    assert j != lathe()


@pytest.mark.slow
def test_the_mark_tells_questions_apart():
    marks = {j.mark for j in (
        job(), job(duration=0.2), job("large"), job("small", "large"), job(controller="p_half"), job(seed=3),
        job(changes={"plant.lag_s": 0.04}),
    )}  # fmt: skip
    assert len(marks) == 7 and job().mark == job().mark


def test_scenarios_share_what_may_vary_and_what_is_measured():
    j = job("small", "large")
    assert "plant.lag_s" in j.sheet() and j.metrics() == ("rms_error", "max_error", "overshoot", "settling")
    assert j.seconds("small") == 0.1 and j.seconds("large") == 0.2
    with pytest.raises(NameUnknown, match="did you mean overshoot"):
        j.check_metric("overshot")
    with pytest.raises(NameUnknown, match="did you mean small"):
        job("smal").loop("smal")


def test_without_scenarios_it_is_the_experiments_own_or_the_first():
    assert Job(Experiment("vud_lathe", "corrected.vud_beta_e")).where == ("fig11a_step_m50",)
    assert Job(Experiment("vud_lathe", "corrected.vud_beta_e", "step_p50")).where == ("step_p50",)


def test_a_continuous_loop_is_refused(tmp_path):
    file = tmp_path / "continuous.py"
    file.write_text(
        "from leadscrew.kernel.loop import Loop\nfrom leadscrew.references._step import step\n"
        "from tests.tune.noisy_loop import gain, slide\n"
        "LOOP = Loop(reference=step(), controller=gain, plant=slide, period=None)\n"
    )
    with pytest.raises(ValueRefused, match="control period"):
        Job(Experiment(f"{file}:LOOP"), (), 0.1).loop("")
