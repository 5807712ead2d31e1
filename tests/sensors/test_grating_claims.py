"""The study's claims about the grating ruler, and its pictures."""

import io
import subprocess
import sys

import numpy as np
import pytest

from leadscrew.studies.vud_lathe import claims_sensor
from leadscrew.studies.vud_lathe.claims_sensor import SPREAD, corrected_um, noisy_count_um, sensor_claims
from leadscrew.studies.vud_lathe.figures_sensor import sensor_pictures
from tests.docs.snippets import ROOT, assert_printed, with_marks

PAGE = ROOT / "docs" / "grating_ruler.md"


def test_every_claim_about_the_ruler_is_met_and_says_why():
    claims = sensor_claims()
    assert [c.id for c in claims if c.kind == "required" and c.passed is not True] == []
    assert len({c.id for c in claims}) == len(claims) > 25
    assert all(c.reason and c.statement and c.source for c in claims)
    assert all(c.verdict == "cannot be checked" for c in claims if c.paper is None)
    by_name = {c.id.removeprefix("vud_lathe."): c for c in claims}
    assert by_name["eq1_unit"].verdict == "not reproduced"
    assert by_name["count_length"].measured == pytest.approx(0.625)


def test_the_wrong_unit_would_be_called_right_if_the_wave_vectors_said_so(monkeypatch):
    monkeypatch.setattr(claims_sensor, "crossed_period_mm", lambda lines, angle: lines / angle)
    claim = next(c for c in claims_sensor._fringe() if c.id.endswith("eq1_unit"))
    assert claim.measured == "yes" and claim.verdict == "reproduced" and claim.passed is False


def test_the_tolerances_of_numbers_with_noise_are_their_spread_over_seeds():
    seeds = range(30)
    assert np.std([noisy_count_um(s) for s in seeds], ddof=1) == pytest.approx(SPREAD["count"], rel=0.01)
    for noise in (0.005, 0.02):
        found = np.array([corrected_um(noise, s) for s in seeds])
        assert found[:, 1].std(ddof=1) == pytest.approx(SPREAD[noise], rel=0.03)
    assert found[:, 2].std(ddof=1) == pytest.approx(SPREAD["peak before"], rel=0.01)
    assert found[:, 3].std(ddof=1) == pytest.approx(SPREAD["peak after"], rel=0.01)


def test_pictures_of_the_ruler_draw_with_units_on_every_axis():
    for picture in sensor_pictures():
        figure = picture.draw()
        figure.savefig(io.BytesIO(), dpi=25)
        labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]
        assert picture.caption and len(labels) >= 4 and all("(" in text for text in labels)


@pytest.mark.slow
def test_the_page_prints_what_it_shows(tmp_path):
    (tmp_path / "page.py").write_text(with_marks(PAGE), encoding="utf-8")
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert_printed(PAGE, done.stdout + done.stderr)
