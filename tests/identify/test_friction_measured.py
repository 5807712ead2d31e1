"""Logs of real machines, against what others published of them; skipped where the data is not at hand."""

import re

import numpy as np
import pytest
from scipy import signal
from scipy.io import loadmat

from leadscrew.identify import friction_record
from leadscrew.identify.friction import fit_friction
from leadscrew.identify.friction_record import checked, sliding
from leadscrew.util.errors import DataError
from tests.docs.snippets import ROOT
from tests.fuzzy.formats_systems import shared

PUBLISHED = {"inertia": 95.109, "viscous": 203.50, "coulomb": 20.394, "offset": -3.165}
"""EMPS: kg, N s/m, N, N; A. Janot, M. Gautier, M. Brunot (2019), as the README of the data gives them."""


@pytest.fixture(scope="module")
def emps():
    """Time in s, force in N, position in m."""
    data = loadmat(shared("data/emps/DATA_EMPS.mat"))
    t, volts, position = (data[name].ravel() for name in ("t", "vir", "qm"))
    return t, volts * data["gtau"].item(), position


def usual_fit(log, slowest):
    """Another method: a Butterworth filter both ways, central differences, least squares over all samples."""
    t, force, position = log
    dt = (t[-1] - t[0]) / (len(t) - 1)
    low = signal.butter(4, 50.0, fs=1.0 / dt, output="sos")
    speed = np.gradient(signal.sosfiltfilt(low, position), dt)
    columns = [np.gradient(speed, dt), speed, np.sign(speed)]
    table = np.column_stack([*(signal.sosfiltfilt(low, c) for c in columns), np.ones_like(t)])
    kept = np.abs(speed) > slowest
    kept[:200] = kept[-200:] = False
    found, *_ = np.linalg.lstsq(table[kept], signal.sosfiltfilt(low, force)[kept], rcond=None)
    return dict(zip(PUBLISHED, found.tolist(), strict=True))


def test_mass_and_friction_of_a_real_ball_screw_axis_are_those_published(emps):
    found = sliding(checked(*emps))
    assert found.inertia == pytest.approx(PUBLISHED["inertia"], rel=0.005)
    at_100 = found.coulomb + 0.1 * found.viscous
    assert at_100 == pytest.approx(PUBLISHED["coulomb"] + 0.1 * PUBLISHED["viscous"], rel=0.005)
    assert found.coulomb == pytest.approx(PUBLISHED["coulomb"], rel=0.07)
    assert found.viscous == pytest.approx(PUBLISHED["viscous"], rel=0.06)
    assert found.offset == pytest.approx(PUBLISHED["offset"], abs=0.3)


def test_the_published_values_come_from_all_samples_and_ours_from_steady_sliding(emps, monkeypatch):
    everywhere, sliding_only, ours = usual_fit(emps, 0.0), usual_fit(emps, 0.02), sliding(checked(*emps))
    monkeypatch.setattr(friction_record, "STEADY", 1e9)
    restless = sliding(checked(*emps))
    for name, value in PUBLISHED.items():
        assert everywhere[name] == pytest.approx(value, rel=0.006), name
    for name in ("viscous", "coulomb", "offset"):
        way = [value[name] for value in (everywhere, sliding_only)] + [getattr(restless, name), getattr(ours, name)]
        assert abs(way[1] - way[3]) < abs(way[0] - way[3]) and abs(way[2] - way[0]) < abs(way[3] - way[0]), name
    assert ours.top_speed == pytest.approx(0.1275, abs=1e-4)


def test_a_log_that_turns_fast_is_not_said_to_tell_bristles(emps):
    with pytest.raises(DataError, match="does not determine the stiffness and the damping"):
        fit_friction(*emps)


def test_the_page_tells_what_was_found(emps, monkeypatch):
    page = (ROOT / "docs" / "identify_friction.md").read_text(encoding="utf-8")
    found = sliding(checked(*emps))
    rows = re.findall(r"^\| (\w+), [^|]+ \| (-?[\d.]+) \| (-?[\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE)
    assert [name for name, *_ in rows] == ["mass", "viscous", "Coulomb", "offset"]
    for (name, published, value, error), key in zip(rows, PUBLISHED, strict=True):
        assert float(published) == PUBLISHED[key], name
        assert float(value) == pytest.approx(getattr(found, key), rel=5e-4), name
        assert float(error) == pytest.approx(found.standard_error[key], rel=0.05), name
    narrowed = usual_fit(emps, 0.02)
    monkeypatch.setattr(friction_record, "STEADY", 1e9)
    restless = sliding(checked(*emps))
    words = " ".join(page.split())
    assert f"they give {narrowed['viscous']:.1f} and {narrowed['coulomb']:.2f}." in words
    assert f"with those it finds {restless.viscous:.1f} and {restless.coulomb:.2f}." in words


def test_records_of_a_tribometer_are_refused_with_the_reason():
    first = np.genfromtxt(shared("data/friction_tribometer/test_data_1.csv"), delimiter=",", names=True)
    way = np.cumsum(first["Velocity"] * np.gradient(first["Time"]))
    with pytest.raises(DataError, match="433 samples"):
        fit_friction(first["Time"], first["Friction"], way)
    t, _, place, force = np.genfromtxt(
        shared("data/friction_tribometer/test_data_2.txt"), delimiter="\t", skip_header=1
    ).T
    with pytest.raises(DataError, match="without gaps"):
        fit_friction(t, force, place)
    with pytest.raises(DataError, match=r"every 0.005 s"):
        fit_friction(0.005 * np.arange(len(t)), force, place)
