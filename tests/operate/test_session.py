"""A session: the same bits again, from the object, its file, its script; and where it parts when it is not the same."""

import re
import runpy
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from leadscrew.figures.table import number
from leadscrew.operate import script, session_file
from leadscrew.operate.operated import Operated, Start
from leadscrew.operate.recorder import Recorder
from leadscrew.report import session as session_report
from leadscrew.util.errors import DataError, NameUnknown, ValueRefused
from tests.operate.bench_study import NAME


@pytest.fixture(scope="module")
def played():
    """A machine on which everything was done, with all its rows."""
    operated = Operated(Start(NAME, "pid", "way", {"scenario.amplitude_mm": 0.5}, seed=3))
    rows = []

    def on(periods):
        part, _ = operated.advance(periods)
        rows.append((operated.columns, part))

    on(123)
    operated.set({"controller.kp": 4.0, "controller.anti_windup": 0})
    on(77)
    operated.disturb("load_pulse", {"size": 0.5, "for_s": 0.02})
    operated.disturb("noise", {"deviation": 0.002, "for_s": 0.05})
    on(100)
    operated.switch("gain")
    on(51)
    operated.set({"controller.kp": 7.0}, why="preset hard")
    on(40)
    operated.undo()
    operated.undo()
    on(109)
    return operated, rows


@pytest.fixture(scope="module")
def session(played):
    return played[0].session()


def test_a_session_runs_again_to_the_same_bits(played, session):
    _, rows = played
    again = session.run(record="*")
    assert again.identical and again.digest == session.digest and again.difference == ""
    assert again.operated.session() == session
    first = 0
    for columns, part in rows:
        for i, name in enumerate(columns):
            assert again.signals[name][first : first + len(part)].tobytes() == part[:, i].tobytes(), name
        first += len(part)
    assert session.periods == first == 500
    assert [e.how for e in session.events if e.do == "switch"] == ["not bumpless", "aligned"]
    assert [e.compare for e in session.events] == [not e.why.startswith("disturb ") for e in session.events]
    assert again.operated.can_undo
    assert {e.why for e in session.events} == {"", "undo", "preset hard", "disturb load_pulse", "disturb noise"}


def test_what_is_recorded_is_chosen_and_never_changes_the_digest(session):
    standard, none = session.run(), session.run(record=())
    assert none.signals == {} and none.identical and standard.identical
    assert "true_error" in standard.signals and "plant.speed" not in standard.signals
    states = session.run(record=("controller",)).signals
    assert np.isfinite(states["controller.integral"][:300]).all()
    assert np.isnan(states["controller.integral"][300:391]).all()
    with pytest.raises(NameUnknown, match="no signal 'outptu'; did you mean output"):
        session.run(record="outptu")
    with pytest.raises(ValueRefused, match=r"needs .* GB: record fewer"):
        Recorder("*", 10**9).feed(["time", "a"], np.zeros((1, 2)))


def test_a_changed_event_makes_it_differ_and_says_where(session):
    event = session.events[0]
    other = replace(event, changes={**event.changes, "controller.kp": 4.000001})
    again = replace(session, events=(other, *session.events[1:])).run(record=())
    assert not again.identical and again.difference == "the signals differ first between t = 0.123 s and 0.2 s"
    seeded = replace(session, start=replace(session.start, seed=4)).run(record=())
    assert seeded.difference == "the signals differ first between t = 0.2 s and 0.25 s"  # noise from there on


def test_the_file_holds_all_of_it(session, tmp_path):
    path = tmp_path / "s.toml"
    session_file.write(session, path)
    assert session_file.read(path) == session
    text = path.read_text(encoding="utf-8")
    assert text.startswith('schema_version = 2\nkind = "session"\n') and text.count("[[event]]") == len(session.events)


def test_values_of_every_type_come_back_from_the_file(tmp_path, session):
    event = session.events[0]
    odd = {"a.b": float("inf"), "a.c": True, "a.d": -0.0, "a.e": 2**52, "a.g": 1e-300, "y.a.f": [[1.5, 2.0]]}
    kept = replace(session, events=(replace(event, changes=odd, why='a "quote"\nand a line'),))
    session_file.write(kept, tmp_path / "s.toml")
    back = session_file.read(tmp_path / "s.toml")
    assert back == kept and repr(back.events[0].changes) == repr(odd)
    scope: dict[str, object] = {}
    exec(script.text(kept, 1e-3).split("\nmachine = ")[0], scope)
    assert scope["events"] == list(kept.events) and scope["start"] == kept.start


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "session"', 'kind = "machine"', "is not a session: its kind is 'machine'"),
        ("periods = 500", "periods = -1", "periods = -1"),
        ("periods = 500", "periods = 200", "event 4 has period = 250; allowed are 200 to 200"),
        ("periods = 500", "", "the key 'periods' is missing"),
        ('do = "set"', 'do = "sets"', "event.1.do = 'sets'"),
        ("[start]", "[start]\nstudi = 1", "did you mean study"),
        ('digest = "', 'digest = "x', "digest = "),
        ("[start]", "[start", "cannot be read as TOML"),
        ('do = "set"', 'do = "set"\ncontroller = "gain"', "event 1: a switch, and nothing else, names a controller"),
        ('how = "ramped"', 'how = "rough"', "event.1.how = 'rough'"),
    ],
)
def test_a_file_that_is_no_session_is_refused_by_its_key(session, tmp_path, old, new, said):
    path = tmp_path / "s.toml"
    text = session_file.text(session)
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(DataError, match=r"s\.toml") as caught:
        session_file.read(path)
    assert said in str(caught.value)


def test_an_event_that_the_machine_cannot_do_is_refused(session):
    unaligned = [replace(e, how="aligned") for e in session.events if e.why == "preset hard"]
    unknown = [replace(e, how="ramped", by="controller.sum") for e in unaligned]
    kept = [e for e in session.events if e.period < unaligned[0].period]
    for wrong, said in ((unaligned, "values are set 'ramped' or 'at once'"), (unknown, "by = 'controller.sum'")):
        with pytest.raises(ValueRefused, match=said):
            replace(session, events=(*kept, *wrong)).run(record=())


def ran(path):
    """What the script says and its exit code."""
    try:
        runpy.run_path(str(path), run_name="__main__")
    except SystemExit as left:
        return str(left.code), 1
    return "", 0


def test_the_script_does_the_same_and_says_so(session, tmp_path, capsys):
    path = tmp_path / "again.py"
    script.write(session, 1e-3, path)
    assert ran(path) == ("", 0)
    assert capsys.readouterr().out.startswith("identical: 500 periods of ")
    text = path.read_text(encoding="utf-8")
    assert "seed=3" in text and "python again.py" in text
    path.write_text(text.replace("'controller.kp': 4.0", "'controller.kp': 4.1"), encoding="utf-8")
    said, code = ran(path)
    assert code == 1 and said.startswith("not identical: the signals part before t = 0.2 s")
    path.write_text(text.replace("periods = 500", "periods = 501"), encoding="utf-8")
    assert "part after the last event" in ran(path)[0]


def test_the_report_has_old_and_new_values_and_the_error_under_each_setting(played, session):
    _, rows = played
    page = session_report.html(session)
    assert "every signal has the same bits" in page and session.digest in page
    assert "plant integrated by rk4 (1 step a period)" in page
    assert "<td>controller.kp</td>" in page and "preset hard" in page
    error = np.concatenate([part[:, columns.index("true_error")] for columns, part in rows])
    for first, last in ((0, 123), (123, 200)):
        piece = 1000.0 * error[first:last]
        for value in (np.sqrt(np.mean(piece**2)), np.abs(piece).max()):
            assert number(float(value)) in page
    assert '<td>controller.kp</td><td class="n">3</td><td class="n">4</td><td></td>' in page
    assert "<td>ramped</td><td>hand</td>" in page and "<td>scenario.amplitude_mm</td>" in page
    made = re.search(r"<p>A slide; this page was made on (.* at .*) UTC", page)
    assert made is not None
    assert abs((datetime.now(UTC) - datetime.strptime(made[1] + "Z", "%Y-%m-%d at %H:%M%z")).total_seconds()) < 120.0
    assert "<svg" in page or "data:image" in page
    assert "<script" not in page


def test_numbers_of_changes_that_come_close_together_do_not_lie_over_each_other():
    assert session_report._numbered([0, 100, 101, 129, 131, 900], 1000) == [
        (0, "1"),
        (100, "2-4"),
        (131, "5"),
        (900, "6"),
    ]
    assert session_report._numbered(list(range(41)), 41) == []


def test_marks_say_where_a_run_parts_in_which_nothing_was_done(played, monkeypatch, tmp_path):
    monkeypatch.setattr("leadscrew.operate.operated.MARKED", 64)
    operated = played[0].restarted()
    operated.advance(150)
    operated.set({"plant.gain": 20.1})
    operated.advance(250)
    kept = operated.session()
    assert list(kept.marks) == [64, 128, 192, 256, 320, 384] and kept.run(record=()).identical
    session_file.write(kept, tmp_path / "s.toml")
    assert session_file.read(tmp_path / "s.toml") == kept
    found = replace(kept, events=()).run(record=())
    assert found.difference == "the signals differ first between t = 0.128 s and 0.192 s"


def test_marks_are_few_however_long_the_run_and_the_same_in_all_pieces(played, monkeypatch):
    monkeypatch.setattr("leadscrew.operate.operated.MARKED", 2)
    monkeypatch.setattr("leadscrew.operate.operated.MARKS", 5)
    whole, cut = played[0].restarted(), played[0].restarted()
    whole.advance(210)
    for _ in range(30):
        cut.advance(7)
    assert list(whole.session().marks) == [64, 128, 192] and whole.session() == cut.session()


def test_a_session_without_any_change_has_a_report_too(played):
    operated = played[0].restarted()
    assert operated.session().run().identical
    assert "Nothing was changed" in session_report.html(operated.session())
