"""The page on harmonics: its table of windows, its sweep, its refusals."""

import matplotlib
import numpy as np
import pytest

from leadscrew.analysis.harmonics import least_squares
from leadscrew.studies.npid_xytable.measurement import LABELS_HZ, by_fft, by_least_squares
from leadscrew.util.errors import ValueRefused
from tests.docs import sessions
from tests.docs.snippets import ROOT, blocks

matplotlib.use("Agg")
PAGE = ROOT / "docs" / "harmonics.md"
METHODS = {
    "no window, 20000 samples, coherent": lambda: by_fft(20000, "rectangular"),
    "no window, 8192 samples": lambda: by_fft(8192, "rectangular"),
    "no window, 16384 samples": lambda: by_fft(16384, "rectangular"),
    "Hann, 8192 samples": lambda: by_fft(8192, "hann"),
    "Hann, 16384 samples": lambda: by_fft(16384, "hann"),
    "flat-top, 8192 samples": lambda: by_fft(8192, "flattop"),
    "least squares, 8192 samples": lambda: by_least_squares(8192),
    "least squares at 2.0, 3.5, 5.0, 6.3, 7.7 Hz, 8192 samples": lambda: by_least_squares(8192, LABELS_HZ),
}


def test_the_table_of_windows_is_what_is_measured():
    seen = {}
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [c.strip() for c in line.strip("|").split("|")]
        if cells[0] in METHODS:
            seen[cells[0]] = [int(c) for c in cells[1:]]
    assert list(seen) == list(METHODS)
    for name, shown in seen.items():
        assert shown == [int(x) for x in np.rint(METHODS[name]()) + 0.0], name


@pytest.mark.slow
def test_the_sweep_of_the_page_prints_what_the_page_shows(tmp_path, monkeypatch):
    from typer.testing import CliRunner

    from leadscrew.cli import app

    monkeypatch.chdir(tmp_path)
    for name, text in sessions.files_of(PAGE).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    session = next(lines for _, lines in blocks(PAGE, ("text",)) if lines and lines[0].startswith("$ "))
    steps = []
    for line in session:
        if line.startswith("$ "):
            steps.append(sessions.Step(line.removeprefix("$ "), [], []))
        else:
            steps[-1].shown.append(line)
    assert len(steps) == 2
    for step in steps:
        done = CliRunner().invoke(app, step.command.split()[1:])
        assert done.exit_code == 0, done.output
        sessions.assert_shown(step, done.stdout)
    assert (tmp_path / "bode.png").exists()


def test_the_refusal_of_the_page_is_the_one_that_comes():
    with pytest.raises(ValueRefused) as refused:
        least_squares(np.arange(4000) / 2000.0, np.zeros(4000), (1100.0,))
    assert f"`{refused.value}`" in PAGE.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(("samples", "shown"), [(20000, 95), (8192, 94), (4096, 88), (2048, 73)])
def test_intervals_hold_as_often_as_the_page_says_in_noise_that_bends(samples, shown):
    from scipy.signal import lfilter

    t, runs = np.arange(samples) / 2000.0, 300
    noise = 0.1 * lfilter([1.0], [1.0, -0.98], np.random.default_rng(3).normal(size=(runs, samples)), axis=-1)
    low, high = least_squares(t, noise + 0.5 * np.sin(2 * np.pi * 2.1 * t + 1.0), (2.1, 30.0)).confidence()
    # Three standard deviations of a share of 300 records.
    assert 100.0 * np.mean((low <= 0.5) & (high >= 0.5), axis=0)[0] == pytest.approx(
        shown, abs=300.0 * np.sqrt(shown * (100.0 - shown) / 1e4 / runs)
    )
    assert f"{shown} %" in PAGE.read_text(encoding="utf-8")


def test_the_bias_of_an_encoder_is_what_the_study_measures():
    from leadscrew.studies.npid_xytable.measurement import encoded, turned
    from leadscrew.studies.npid_xytable.table2 import PID_UM

    off = [np.abs(encoded(4, tuple(p)).mean(axis=0) - np.array(PID_UM[1000])).max() for p in turned(20)]
    assert round(float(np.median(off)), 2) == 0.01 and round(float(np.max(off)), 3) == 0.025
