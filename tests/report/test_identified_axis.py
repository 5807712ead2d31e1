"""What a reader sees of an identified axis: tables, sentences, and the folder with its page."""

import json
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.identify.estimation import Parameter
from leadscrew.report import identified_axis as tables
from leadscrew.report.identified_axis import page_of, scaled, sentences, write
from leadscrew.util.errors import DataError
from tests.report.axis_fits import alike, made_up, stretch


def row(rows, name):
    return next(r for r in rows if r[0] == name)


def test_a_number_carries_the_prefix_that_suits_it():
    assert [scaled(x, "m") for x in (2.61e-3, 3.04e-6, 0.0, 0.2455, 12.0, 4e-10)] == [
        "2.61 mm", "3.04 µm", "0 m", "245.5 mm", "12 m", "0.4 nm",
    ]  # fmt: skip
    assert scaled(float("nan"), "m") == "–"


def test_every_parameter_says_how_it_was_found_and_why_it_has_no_interval():
    rows = tables.parameter_table(made_up()).rows
    assert row(rows, "mass") == ["mass", "20", "19.9", "20.1", "kg", "fitted", "moving mass"]
    assert row(rows, "friction.backward.viscous")[5] == "not identifiable"
    assert row(rows, "friction.backward.viscous")[6] == "viscous friction, backward: it never moves fast"
    assert row(rows, "force_per_drive")[2:6] == ["–", "–", "N/V", "given"]
    assert row(rows, "backlash")[5:] == ["fixed", "lost motion: one encoder cannot see lost motion"]
    assert row(rows, "delay_s")[6] == "delay of the drive: no interval is known"


def test_a_narrow_interval_is_shown_with_the_digits_that_it_needs():
    fit = made_up()
    fit.parameters["mass"] = Parameter(60.00002, "kg", 59.99502, 60.00502, "fitted", True)
    assert row(tables.parameter_table(fit).rows, "mass")[1:4] == ["60.0000", "59.9950", "60.0050"]


def test_reasons_stand_below_the_table_once_for_all_that_they_are_about():
    rows, lines = tables.parameter_table(made_up(), reasons=False).rows, tables.reason_lines(made_up())
    assert row(rows, "backlash")[6] == "lost motion"
    assert "backlash: one encoder cannot see lost motion" in lines and len(lines) == 3
    same = made_up()
    same.parameters["offset"] = same.parameters["backlash"]
    assert "offset, backlash: one encoder cannot see lost motion" in tables.reason_lines(same)


def test_friction_alike_both_ways_stands_once():
    names = [r[0] for r in tables.parameter_table(alike()).rows]
    assert "friction.forward.coulomb" in names and not any(".backward." in n for n in names)
    assert row(tables.parameter_table(alike()).rows, "friction.forward.viscous")[6] == "viscous friction, both ways"
    assert len(tables.parameter_table(made_up()).rows) == len(names) + 2


def test_errors_are_shown_by_stretch_in_units_of_their_size():
    rows = tables.score_table(made_up()).rows
    assert [r[0] for r in rows] == ["training", "hold-out", "whole log, closed loop"]
    assert [r[3] for r in rows] == ["16 µm", "20 µm", "200 nm"]
    assert rows[1][1:3] == ["5", "9.999"] and rows[1][5] == "0.01" and rows[1][6].endswith(" N")


def test_the_error_on_unseen_data_comes_first_and_with_its_ratio():
    said = sentences(made_up())
    assert "5 to 9.999 s) the simulated position is off by 20 µm rms" in said[2]
    assert said[3] == "that is 1.25 times the error on the data of the fit"
    assert any("a controller hides faults of a model" in s and "200 nm" in s for s in said)
    assert "not identifiable from this log: friction.backward.viscous, backlash" in said


def test_a_model_that_does_not_carry_over_is_said_so():
    worse = replace(stretch(rms=2.1e-3), force_percent=9.0)
    fit = made_up(judged=[replace(stretch("training", 0.0, 1e-3), force_percent=5.0), worse])
    said = "that is 2.1 times the error on the data of the fit; 9 % of the force is left there, 5 % here"
    assert any(s.startswith(said + ": the model kn") for s in sentences(fit))
    fit = made_up(judged=[replace(stretch("training", 0.0, 1e-3), force_percent=8.0), worse])
    assert any("small forces add up in the position" in s for s in sentences(fit)) and fit.faults == []
    near = made_up(judged=[stretch("training", 0.0, 1e-6), stretch(rms=2.1e-6)])
    assert "that is 2.1 times the error on the data of the fit" in sentences(near), "0.001 % of the range"


def test_without_a_hold_out_no_error_is_sold_as_one_on_unseen_data():
    said = sentences(made_up(judged=[stretch("training", 0.0)]))
    assert said[2].startswith("no hold-out") and not any("has not seen (" in s for s in said)
    assert tables.summary(made_up(judged=[stretch("training", 0.0)]))["holdout_over_training"] is None


def test_a_high_condition_number_is_put_in_words():
    assert not any("trade with one another" in s for s in sentences(made_up(condition=99.0)))
    assert any(s.startswith("condition number 340:") for s in sentences(made_up(condition=340.0)))


def test_a_rotary_axis_in_volts_is_never_given_in_newtons():
    volts = {"mass": Parameter(0.02, "V s^2/rad", 0.019, 0.021, "fitted", True),
             "friction.forward.coulomb": Parameter(0.6, "V", 0.59, 0.61, "fitted", True)}  # fmt: skip
    fit = made_up(position_unit="rad", parameters=volts, correlation={})
    assert row(tables.parameter_table(fit).rows, "mass")[4:] == ["V s²/rad", "fitted", "moving inertia"]
    assert tables.score_table(fit).rows[1][3] == "20 µrad" and tables.score_table(fit).rows[1][6].endswith(" V")


def test_correlations_stand_below_the_diagonal():
    fit = made_up()
    fit.correlation["offset"]["mass"] = -0.73
    table = tables.correlation_table(fit)
    columns, rows = table.heads, table.rows
    assert columns[1] == "mass" and rows[0][0] == "offset"
    assert rows[0][1] == "−0.73" and rows[0][2] == "" and len(rows) == 5 and len(columns) == 6


@pytest.mark.slow
def test_the_folder_holds_page_pictures_json_and_machine(tmp_path):
    out = tmp_path / "report"
    write(
        made_up(judged=[stretch(samples=500)]),
        out,
        lambda path: path.write_text("kind"),
        ["a gap of 3 samples at 1.2 s"],
    )
    assert sorted(p.name for p in out.iterdir()) == [
        "axis.json", "axis.toml", "friction.png", "parameters.png", "position.png", "report.html", "residual.png",
    ]  # fmt: skip
    found = json.loads((out / "axis.json").read_text(encoding="utf-8"))
    assert found["schema_version"] == 1 and found["findings"] == ["a gap of 3 samples at 1.2 s"]
    assert found["parameters"]["backlash"]["low"] is None and found["holdout_over_training"] is None
    page = (out / "report.html").read_text(encoding="utf-8")
    for text in ("A gap of 3 samples at 1.2 s.", "Move faster backwards.", "Correlation of the estimates", "axis.toml"):
        assert text in page
    assert page.count("data:image/") == 4 and "<script" not in page
    with pytest.raises(DataError, match="exists already"):
        write(made_up(), out)


def test_a_name_of_a_log_is_text_on_the_page_and_nothing_else():
    page = page_of(replace(made_up(), source="<b>log.csv", notes=["<i>odd</i>"]), {})
    assert "<b>log" not in page and "&lt;b&gt;log.csv" in page and "<i>odd" not in page
    assert "machine file" not in page


def test_a_report_that_fails_on_the_way_leaves_nothing(tmp_path):
    def fails(path):
        raise DataError("no")

    with pytest.raises(DataError):
        write(made_up(), tmp_path / "report", fails)
    assert list(tmp_path.iterdir()) == []


def test_the_numbers_of_the_json_are_those_of_the_fit():
    found = tables.summary(made_up())
    assert found["parameters"]["mass"]["value"] == 20.0 and found["judged"][1]["rms"] == 2e-5
    assert np.isclose(found["holdout_over_training"], 2e-5 / 1.6e-5)
