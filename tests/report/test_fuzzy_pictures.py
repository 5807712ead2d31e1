"""Pictures of fuzzy systems: what they show is what the system computes."""

import io
import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.explanation import activity
from leadscrew.fuzzy.formats import fld
from leadscrew.fuzzy.shapes import membership
from leadscrew.fuzzy.system import And, Input, Is, Output, Rule, RuleBlock, System, Term
from leadscrew.report import fuzzy as pictures
from leadscrew.report.fuzzy.membership import curve, rows_of
from leadscrew.report.fuzzy.rules import brief, gathered
from leadscrew.report.fuzzy.surfaces import label_places
from leadscrew.report.fuzzy.words import ends, formula, number
from leadscrew.util.errors import NameUnknown, ValueRefused
from tests.budget import in_every_run
from tests.fuzzy.formats_systems import shared
from tests.fuzzy.systems import LABELS, mamdani, sugeno, triangles, with_output
from tests.fuzzy.test_activity import FEEDER


def with_units(system: System) -> System:
    units = iter(("mm", "mm/s", "V"))
    return replace(
        system,
        inputs=tuple(replace(v, unit=next(units)) for v in system.inputs),
        outputs=tuple(replace(v, unit=next(units)) for v in system.outputs),
    )


def three_inputs() -> System:
    ins = tuple(
        Input(n, -1.0, 3.0, triangles(LABELS[:2], -1.0, 3.0), unit=u)
        for n, u in zip("abc", ("mm", "", "N"), strict=True)
    )
    outs = tuple(Output(n, -1.0, 1.0, triangles(LABELS[:3], -1.0, 1.0)) for n in ("u", "v"))
    rules = tuple(
        Rule(And(And(Is("a", a), Is("b", b)), Is("c", c)), (Is("u", a), Is("v", c)))
        for a in LABELS[:2] for b in LABELS[:2] for c in LABELS[:2]
    )  # fmt: skip
    return System("three", ins, outs, (RuleBlock(rules),))


def said(figure) -> str:
    """Every text of a figure that is shown."""
    import matplotlib.text

    return "\n".join(t.get_text() for t in figure.findobj(matplotlib.text.Text) if t.get_visible() and t.get_text())


def drawn(figure) -> bytes:
    """The figure as a picture; nothing about it is warned of."""
    held = io.BytesIO()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure.savefig(held, format="png", dpi=50)
    return held.getvalue()


# ---- membership functions
def test_every_variable_has_a_panel_with_unit_universe_and_terms():
    figure = pictures.membership_figure(with_units(sugeno()))
    text = said(figure)
    for words in (
        "e (mm)",
        "de (mm/s)",
        "u (V)",
        "input, −1 to 1",
        "weighted average, −1 to 1",
        "NB\n−1",
        "PS\n0.3333",
    ):
        assert words in text
    assert text.count("NM") == 3
    assert drawn(figure).startswith(b"\x89PNG")


def test_curves_are_the_membership_functions():
    figure = pictures.membership_figure(mamdani())
    ax = figure.axes[0]
    for term, line in zip(mamdani().inputs[0].terms, ax.get_lines(), strict=True):
        xs, ys = line.get_data()
        for x, y in list(zip(xs, ys, strict=True))[::37]:
            assert y == membership(term, float(x)) if not math.isnan(y) else membership(term, float(x)) == 0.0
    styles = {(line.get_color(), line.get_linestyle()) for line in ax.get_lines()}
    assert len(styles) == 7 and len({style for _, style in styles}) > 1


def test_a_jump_is_drawn_upright():
    xs, ys = curve(Term("on", "rectangle", (2.0, 3.0)), 0.0, 10.0)
    assert (xs[np.flatnonzero(np.diff(ys))] >= np.nextafter(2.0, 0.0)).all()
    assert np.diff(xs)[np.flatnonzero(np.diff(ys))].max() < 1e-12


def test_labels_that_would_touch_go_to_rows_of_their_own():
    assert rows_of([(0.0, 1.0, 1.0), (2.0, 3.0, 1.0)]) == [0, 0]
    assert rows_of([(2.0, 3.0, 1.0), (2.5, 3.5, 1.0), (3.1, 4.0, 0.9)]) == [0, 1, 0]
    assert rows_of([(0.0, 1.0, 1.0)] * 4) is None


@pytest.mark.slow
def test_many_terms_get_a_legend_and_very_many_are_counted():
    many = tuple(Term(f"a_long_name_{i}", "triangle", (i - 1.0, float(i), i + 1.0)) for i in range(14))
    lots = tuple(Term(f"c{i}", "constant", (i / 7.0,)) for i in range(30))
    system = replace(
        FEEDER,
        inputs=(*FEEDER.inputs, Input("y", 0.0, 13.0, many)),
        outputs=(replace(FEEDER.outputs[0], terms=(*FEEDER.outputs[0].terms, *lots)),),
    )
    figure = pictures.membership_figure(system)
    assert figure.axes[1].get_legend() is not None
    assert len(figure.axes[1].get_legend().get_texts()) == 14
    assert "31 terms, from c0: 0 to" in said(figure)
    drawn(figure)


def test_linear_consequents_are_said_as_text():
    system = sugeno()
    terms = [
        Term("z0", "linear", (0.5, -2.0, 1.0)),
        Term("z1", "linear", (0.0, 1.0, 0.0)),
        Term("z2", "constant", (0.0,)),
    ]
    assert [formula(t, system) for t in terms] == ["0.5 e − 2 de + 1", "de", "0"]
    assert formula(Term("short", "linear", (-1.0, -3.0)), system) == "−e − 3"
    made = replace(system, outputs=(replace(system.outputs[0], terms=(*system.outputs[0].terms, *terms)),))
    text = said(pictures.membership_figure(made))
    assert "NB = −1" in text and "and 2 more" in text


@pytest.mark.slow
def test_odd_variables_are_drawn_too():
    endless = Input(
        "endless", -math.inf, math.inf, (Term("low", "gaussian", (0.0, 1.0)), Term("hi", "sigmoid", (3.0, 4.0)))
    )
    system = replace(
        FEEDER, name="costs $5 or $6", inputs=(*FEEDER.inputs, endless, Input("bare", 0.0, math.inf, (), enabled=False))
    )
    assert ends(system, endless) == (-4.0, 5.25)
    assert ends(system, system.inputs[2]) == (0.0, 1.0)
    figure = pictures.membership_figure(system)
    text = said(figure)
    assert "no terms" in text and "switched off, 0 to ∞" in text and r"costs \$5 or \$6" in text
    drawn(figure)


# ---- surface
def test_the_surface_is_what_the_system_computes():
    system = three_inputs()
    made = pictures.surface(system, "c", "a", {"b": 0.5}, points=7)
    f = compiled(system)
    for i, a in enumerate(made.ys):
        for j, c in enumerate(made.xs):
            assert f(a=a, b=0.5, c=c) == {"u": made.values[i, j, 0], "v": made.values[i, j, 1]}
    names, rows = made.rows()
    assert names == ["a", "b", "c", "u", "v"]
    assert rows.shape == (49, 5) and (rows[:, 1] == 0.5).all()
    assert rows[1, 0] > rows[0, 0] and rows[1, 2] == rows[0, 2]
    assert f(a=rows[9, 0], b=0.5, c=rows[9, 2])["v"] == rows[9, 4]


@pytest.mark.slow
def test_the_table_of_two_inputs_is_the_reference_table_of_the_files():
    system, f = mamdani(), compiled(mamdani())
    wanted = fld.dumps(system, lambda p: (f.scalar(*p),), 5, each=True).splitlines()
    names, rows = pictures.surface(system, points=5).rows()
    assert wanted[0].split() == names
    found = [[float(x) for x in line.split()] for line in wanted[1:]]
    assert np.allclose(rows, found, rtol=0.0, atol=1e-15)


def test_held_inputs_stand_in_the_title_with_their_unit_and_default_to_the_middle():
    figure = pictures.surface_figure(three_inputs(), "a", "b", output="v", points=9)
    text = said(figure)
    assert "three: v at c = 1 N" in text
    assert "a (mm)" in text and "\nb\n" in text
    assert "at b = −0.25, " not in text
    assert "at a = 2 mm" in said(pictures.surface_figure(three_inputs(), "b", "c", at={"a": 2.0}, points=9))


@pytest.mark.parametrize(("kind", "axes"), [("both", 3), ("map", 2), ("3d", 2)])
def test_map_relief_and_colour_bar(kind, axes):
    figure = pictures.surface_figure(with_units(sugeno()), points=21, kind=kind)
    assert len(figure.axes) == axes
    text = said(figure)
    assert "u (V)" in text and "e (mm)" in text and "de (mm/s)" in text
    # the numbers at the contours
    assert (len(figure.axes[0].texts) > 5) == (kind != "3d")
    drawn(figure)


@pytest.mark.parametrize("turned", [False, True])
def test_the_relief_shows_its_slope_in_profile_and_fills_its_panel(turned):
    system = with_units(sugeno())
    made = pictures.surface(system, points=21)
    if turned:
        made = replace(made, values=made.values[::-1])
    figure = pictures.surface_figure(made, kind="both")
    drawn(figure)
    relief = figure.axes[-1]
    camera = np.radians(relief.azim)
    uphill = np.array([1.0, -1.0 if turned else 1.0]) / np.sqrt(2.0)
    assert abs(np.dot(uphill, [np.cos(camera), np.sin(camera)])) < 0.2
    frame, page = relief.get_tightbbox(), figure.bbox
    assert frame.width > 0.35 * page.width and frame.height > 0.65 * page.height
    assert page.x0 < frame.x0 and frame.x1 < page.x1 and page.y0 < frame.y0


def test_the_colours_of_the_map_are_the_values():
    system = sugeno()
    figure = pictures.surface_figure(system, points=11, kind="map")
    shown = figure.axes[0].images[0].get_array()
    x = np.linspace(-1.0, 1.0, 11)
    assert np.array_equal(np.ravel(shown), compiled(system).many(e=x[None, :], de=x[:, None]).ravel())


@pytest.mark.slow
def test_where_there_is_no_value_it_is_hatched_and_said():
    partly = mamdani()
    partly = replace(partly, blocks=(replace(partly.blocks[0], rules=partly.blocks[0].rules[:20]),))
    figure = pictures.surface_figure(partly, points=21)
    assert "no value: no rule fires" in said(figure)
    drawn(figure)
    kept = pictures.surface_figure(with_output(partly, lock_previous=True), points=21, kind="map")
    assert "no rule fires: the last value stays" in said(kept)
    assert np.isnan(pictures.surface(with_output(partly, lock_previous=True), points=5).values[-1, -1, 0])
    off = pictures.surface_figure(with_output(partly, enabled=False), points=5)
    assert "switched off" in said(off)
    drawn(off)


def test_one_input_gives_a_line_and_a_level_surface_has_no_contours():
    figure = pictures.surface_figure(FEEDER, points=101)
    (line,) = figure.axes[0].get_lines()
    assert line.get_xdata()[0] == 0.0 and line.get_ydata()[-1] == 1.0
    assert "no value: no rule fires" in said(figure)
    level = sugeno()
    level = with_output(level, terms=tuple(replace(t, parameters=(0.5,)) for t in level.outputs[0].terms))
    flat = pictures.surface_figure(level, points=11)
    assert len(flat.axes[0].texts) == 0
    drawn(flat)


def test_numbers_of_contours_keep_apart():
    ways = [np.column_stack([np.linspace(0, 1, 50), np.full(50, y)]) for y in (0.5, 0.52, 0.02)]
    first, second, edge = label_places(ways)
    assert edge is None
    assert np.hypot(*(first - second)) > 0.05


def test_what_cannot_be_drawn_is_refused_by_name():
    system = three_inputs()
    for wrong, words in (
        ({"x": "d"}, "no input 'd'"),
        ({"x": "a", "y": "a"}, "both 'a'"),
        ({"at": {"a": 1.0}}, "the input a is drawn"),
        ({"at": {"q": 1.0}}, "no input 'q'"),
        ({"output": "w"}, "no output 'w'"),
        ({"points": 1}, "allowed are 2 to"),
        ({"kind": "4d"}, "there are both, map, 3d"),
    ):
        with pytest.raises((NameUnknown, ValueRefused), match=words):
            pictures.surface_figure(system, **{"points": 5, **wrong})
    with pytest.raises(ValueRefused, match="no other input than 'gap'"):
        pictures.surface(FEEDER, y="gap")


# ---- activity
@pytest.mark.slow
def test_the_rows_of_the_map_are_the_rules_that_fire():
    system, t = with_units(sugeno()), np.linspace(0.0, 2.0, 201)
    x = np.column_stack([np.exp(-t), -0.3 * np.exp(-t)])
    figure = pictures.activity_figure(system, t, x)
    strengths = activity(system, x)
    fired = np.flatnonzero(strengths.any(axis=0))
    rules = figure.axes[3]
    labels = [label.get_text().split()[-1] for label in rules.get_yticklabels()]
    assert labels == [str(i + 1) for i in fired]
    cells = rules.collections[0].get_array()
    assert np.array_equal(np.ma.filled(cells, 0.0).reshape(len(fired), -1), strengths[:, fired].T)
    text = said(figure)
    assert f"sugeno49: {len(fired)} of 49 rules fire" in text
    assert "e ZE and de ZE → u ZE  " in text and "time (s)" in text and "e (mm)" in text and "u (V)" in text
    assert figure.axes[2].get_lines()[0].get_ydata().tolist() == compiled(system).many(x).tolist()
    drawn(figure)


def test_times_in_which_no_rule_fires_are_hatched():
    t = np.arange(60.0)
    gap = np.linspace(0.0, 10.0, 60)[:, None]
    assert "no rule fires" in said(pictures.activity_figure(FEEDER, t, gap))
    silent = pictures.activity_figure(FEEDER, t, np.full((60, 1), 5.0), unit="")
    assert "0 of 3 rules fire" in said(silent) and "row" in said(silent)
    drawn(silent)


def test_a_long_run_is_put_together_without_losing_a_spike():
    t = np.arange(100_000) * 1e-3
    strengths = np.zeros((100_000, 2))
    strengths[54_321, 1] = 0.75
    edges, cells = gathered(t, strengths)
    assert len(edges) == len(cells) + 1 <= 1201
    assert cells.max() == 0.75 and (cells > 0.0).sum() == 1
    at = int(np.argmax(cells[:, 1]))
    assert edges[at] <= t[54_321] < edges[at + 1]


@pytest.mark.slow
def test_many_rules_have_their_numbers_only():
    system = mamdani()
    t = np.linspace(0.0, 1.0, 400)
    x = np.column_stack([np.sin(40 * t), np.sin(50 * t + 1.0)])
    figure = pictures.activity_figure(system, t, x)
    assert all(label.get_text().isdigit() for label in figure.axes[3].get_yticklabels())
    with pytest.raises(ValueRefused, match="two or more"):
        pictures.activity_figure(system, [0.0], [[0.0, 0.0]])


def test_a_rule_in_short_keeps_what_it_concludes():
    rule = Rule(And(Is("cutting_force_x", "b" * 30), Is("c", "d")), (Is("u", "PB"),))
    assert brief(rule) == "cutting_force… bbbbbbbbbbbbb… and c d → u PB"
    rule = Rule(And(Is("a" * 30, "b" * 30), And(rule.antecedent, rule.antecedent)), (Is("u", "PB"),))
    assert brief(rule).endswith("… → u PB") and len(brief(rule)) <= 60
    assert brief(Rule(Is("e", "NB", ("very",)), (Is("u", "PB"),), 0.5)) == "e very NB → u PB with 0.5"


def test_numbers_have_a_true_minus_sign():
    assert [number(x) for x in (-0.25, 1e-7, -math.inf)] == ["−0.25", "1e−07", "−∞"]


@pytest.mark.parametrize("name", in_every_run(["tipper.fis", "tipper.xml", "container_crane.fcl"], ["tipper.xml"]))
def test_files_of_others_are_drawn(name):
    system = formats.read(shared(f"data/fuzzy/{name}"), leave_out_unknown=True)
    drawn(pictures.membership_figure(system))
    drawn(pictures.surface_figure(system, points=11, kind="map"))
