"""The numbers above the plots and the axis about a tolerance: against numpy, run by node."""

from typing import Any

import numpy as np
import pytest

from tests.panel.web.test_views import in_node

READ = """
const { History } = await from('history.js'), r = await from('readouts.js');
const history = new History(['force', 'speed'], 1024);
history.push(0, 1, given.rows.length, Float32Array.from(given.rows.flat()));
const value = (readout) => r.valueOf({ factor: 1, per: '', shows: 'mean', ...readout }, history, given.from,
  (key) => given.parameters[key] ?? NaN);
"""


@pytest.fixture(scope="module")
def rows() -> np.ndarray:
    rng = np.random.default_rng(4)
    return np.stack([rng.normal(150.0, 4.0, 300), rng.normal(0.0, 1.0, 300)], axis=1)


def read(rows: np.ndarray, script: str, since: int) -> Any:
    parameters = {"plant.spindle_rpm": 1200.0}
    return in_node(READ + script, {"rows": rows.tolist(), "from": since, "parameters": parameters})


def test_force_is_shown_as_the_mean_of_what_came_and_an_error_by_its_largest_swing(rows: np.ndarray) -> None:
    script = "say([value({ source: 'force' }), value({ source: 'speed', shows: 'peak', factor: 1000 })]);"
    force, speed = read(rows, script, 50)
    assert force == pytest.approx(rows[50:, 0].mean(), rel=1e-6)
    swing = rows[50:, 1]
    assert speed == pytest.approx(1000.0 * swing[np.argmax(np.abs(swing))], rel=1e-6)


def test_the_feed_of_a_revolution_is_the_feed_rate_over_the_spindle_speed_that_was_set(rows: np.ndarray) -> None:
    script = "say([value({ source: 'plant.spindle_rpm' }), value({ source: 'force', per: 'plant.spindle_rpm' })]);"
    rpm, per_turn = read(rows, script, 0)
    assert rpm == 1200.0
    assert per_turn == pytest.approx(rows[:, 0].mean() / 1200.0, rel=1e-6)


def test_a_gap_in_the_samples_does_not_spoil_a_readout_and_a_signal_that_is_gone_is_no_number(rows: np.ndarray) -> None:
    broken = rows.copy()
    broken[100] = np.nan
    script = (
        "say([value({ source: 'force' }), value({ source: 'torque' }), value({ source: 'speed', shows: 'peak' })]);"
    )
    force, torque, speed = in_node(
        READ.replace(
            "Float32Array.from(given.rows.flat())",
            "Float32Array.from(given.rows.flat(), (v) => v === null ? NaN : v)",
        )
        + script,
        {
            "rows": [[None if np.isnan(x) else float(x) for x in row] for row in broken],
            "from": 90,
            "parameters": {},
        },
    )
    assert force == pytest.approx(np.nanmean(broken[90:, 0]), rel=1e-6)
    assert torque == "NaN"
    assert abs(speed) == pytest.approx(np.nanmax(np.abs(broken[90:, 1])), rel=1e-6)


def test_a_machine_without_readouts_of_its_own_shows_its_first_signals_each_once() -> None:
    trace = {"label": "x", "unit": "mm", "factor": 1000.0, "role": "error"}
    plots = [{"traces": [{**trace, "signal": f"s{i}"} for i in range(5)]},
             {"traces": [{**trace, "signal": f"s{i}", "role": "other"} for i in range(3, 9)]}]  # fmt: skip
    found = in_node("say((await from('readouts.js')).readoutsOf(given));", {"plots": plots})
    assert [r["source"] for r in found] == ["s0", "s1", "s2", "s3", "s4", "s5"]
    assert [r["shows"] for r in found] == ["peak"] * 5 + ["mean"]
    assert all(r["factor"] == 1000.0 for r in found)


def test_the_axis_about_a_tolerance_is_three_bands_high_with_the_band_in_its_middle() -> None:
    script = "say((await from('tolerance.js')).toleranceAxis(given.bands, (band) => given.about[band.about] ?? NaN));"
    zero = in_node(script, {"bands": [{"low": -2, "high": 2, "about": ""}], "about": {}})
    assert zero == {"min": -6, "max": 6}
    two = [{"low": -1.5, "high": 1.5, "about": "command"}, {"low": 1.5, "high": 2.25, "about": "command"}]
    moved = in_node(script, {"bands": two, "about": {"command": 150.0}})
    assert (moved["min"], moved["max"]) == (150 - 1.5 - 3.75, 150 + 2.25 + 3.75)
    assert in_node(script, {"bands": two, "about": {}}) is None, "no axis about a signal that has no value"
