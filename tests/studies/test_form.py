"""The form of a study: a measure is computed once whoever asks, a verdict follows from its numbers, a miss is seen."""

import threading
import time

import pytest

from leadscrew.studies import results
from leadscrew.studies.claims import Measured, at_least, at_most, claim, equals, to_its_digits, verdict_of, within
from leadscrew.studies.lab import Lab, measure
from leadscrew.util.errors import BlockError, DataError, ValueRefused


@pytest.fixture
def lab():
    return Lab(None)


def test_a_measure_is_computed_once_for_all_threads_that_ask(lab):
    asked, got = [], []

    @measure
    def slow(lab, x):
        asked.append(x)
        time.sleep(0.05)
        return [x]

    threads = [threading.Thread(target=lambda: got.append(slow(lab, 3))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert asked == [3] and all(value is got[0] for value in got)
    assert slow(lab, 4) == [4] and asked == [3, 4]
    assert slow(Lab(None), 3) == [3] and asked == [3, 4, 3], "another lab measures for itself"


def test_a_measure_that_fails_fails_for_everyone_and_one_that_takes_itself_is_refused(lab):
    @measure
    def broken(lab):
        raise ValueError("no")

    @measure
    def circular(lab):
        return circular(lab)

    for _ in range(2):
        with pytest.raises(ValueError, match="no"):
            broken(lab)
    with pytest.raises(RecursionError, match="circular needs its own result"):
        circular(lab)


@pytest.mark.parametrize(
    ("basis", "measured", "verdict"),
    [
        ("arithmetic", Measured(printed=1.9), "reproduced"),
        ("arithmetic", Measured(printed=2.1, corrected=1.9), "reproduced with a change"),
        ("arithmetic", Measured(printed=2.1, corrected=2.2, ours=0.1), "not reproduced"),
        ("arithmetic", Measured(ours=0.1), "not testable here"),
        ("arithmetic", Measured(printed=float("inf")), "not reproduced"),
        ("arithmetic", Measured(printed=float("nan")), "not reproduced"),
        ("fitted", Measured(printed=1.9), "fitted"),
        ("fitted", Measured(ours=1.9), "fitted"),
        ("fitted", Measured(corrected=2.1), "not reproduced"),
        ("arithmetic", Measured(printed=0.1, corrected=9.0, holds=[False, True]), "reproduced with a change"),
    ],
)
def test_a_verdict_follows_from_the_columns(basis, measured, verdict):
    assert verdict_of(basis, measured, at_most(2.0)) == verdict


def test_a_number_is_met_to_half_a_unit_of_its_last_printed_digit():
    assert to_its_digits("0.404").met(0.40398) and not to_its_digits("0.404").met(0.4046)
    assert to_its_digits("36").met(36) and not to_its_digits("36").met(36.4)
    assert within(-0.25, 0.005).met(-0.2547) and at_least(2.0).met(2.0) and equals("PB").met("PB")


def test_cases_give_a_claim_each_and_the_statement_names_them(lab):
    lab.study = type("Study", (), {"name": "tiny"})

    @claim("(1)", "equation 1", unit="um", basis="arithmetic", over={"a": 1.0, "b": 2.0})
    def error(lab, case):
        """Error of {case}"""
        return Measured(printed=case, says="1.0", note="why")

    first, second = error.judged(lab)
    assert (first.id, first.statement, first.verdict) == ("tiny.error.a", "Error of 1.0", "reproduced")
    assert (second.id, second.verdict, second.columns()) == ("tiny.error.b", "not reproduced", {"as printed": 2.0})
    assert first.as_dict()["items"] == ["equation 1"]


def test_a_number_out_of_its_tolerance_is_a_miss_and_a_broken_file_is_refused(tmp_path):
    (tmp_path / results.EXPECTED).write_text("id,target,tolerance\na,1.0,0.1\nb,never,\nc,inf,0\nd,nan,0\n")
    rows = results.expected(tmp_path)
    inf, nan = float("inf"), float("nan")
    assert not list(results.misses({"a": 1.05, "b": "never", "c": inf, "d": nan, "new": 5.0}, rows))
    missed = {m.id for m in results.misses({"a": 1.2, "b": "soon", "c": 1.0, "d": 1.0}, rows)}
    assert missed == {"a", "b", "c", "d"}
    assert [m.id for m in results.misses({"a": nan}, rows)] == ["a"]
    assert [m.id for m in results.misses({"c": 1.0}, {"c": ("inf", inf)})] == ["c"], "a time that was never reached"
    (tmp_path / results.EXPECTED).write_text("id,target,tolerance\na,1.0,much\n")
    with pytest.raises(DataError, match=r"expected\.csv, line 2: expected id, target and tolerance"):
        results.expected(tmp_path)
    for wrong in ("a,1.0,0.1\na,2.0,0.1\n", "a,1.0,-1\n", "a,1.0,nan\n"):
        (tmp_path / results.EXPECTED).write_text(f"id,target,tolerance\n{wrong}")
        with pytest.raises(DataError, match=r"expected\.csv, line \d: (an id|a tolerance)"):
            results.expected(tmp_path)
    assert results.expected(tmp_path / "none") == {}


def test_the_example_of_the_guide_is_a_complete_study(tmp_path, monkeypatch):
    from leadscrew import resolve
    from tests.docs.snippets import ROOT, python_of

    (tmp_path / "tiny.py").write_text(python_of(ROOT / "CONTRIBUTING.md"))
    monkeypatch.chdir(tmp_path)
    found = results.evaluate(resolve.study("tiny.py:STUDY"))
    (row,), (shown,) = found.claims, found.experiments
    assert (row.verdict, row.as_printed) == ("reproduced", pytest.approx(0.1))
    assert shown.table.rows["ours.pi"] == (pytest.approx(0.0, abs=1e-6),)
    assert found.figures[0].draw(found.lab).axes
    file = results.write_expected(found)
    assert results.evaluate(resolve.study("tiny.py:STUDY")).missed == []
    with file.open("a") as rows:
        rows.write("gone/ours,1.0,0\n")
    assert [m.id for m in results.evaluate(resolve.study("tiny.py:STUDY")).missed] == ["gone/ours"]


def test_a_claim_that_raises_is_named_and_two_of_one_name_are_refused():
    from dataclasses import replace

    from tests.cli.tiny_study import STUDY

    @claim("(2)", basis="arithmetic")
    def broken(lab):
        return Measured(printed={}["nothing"])

    contents = STUDY.contents()
    with pytest.raises(BlockError, match="broken could not be measured: KeyError: 'nothing'"):
        results.evaluate(replace(STUDY, contents=lambda: contents._replace(claims=[broken])))
    with pytest.raises(ValueRefused, match="more than one claim or experiment of the name broken"):
        results.evaluate(replace(STUDY, contents=lambda: contents._replace(claims=[broken, broken])))


def test_measures_that_need_each_other_are_refused_also_across_threads(lab):
    gate = threading.Barrier(2)

    @measure
    def first(lab):
        gate.wait()
        return second(lab)

    @measure
    def second(lab):
        gate.wait()
        return first(lab)

    refused = []

    def ask(function):
        try:
            function(lab)
        except RecursionError as error:
            refused.append(str(error))

    threads = [threading.Thread(target=ask, args=(f,), daemon=True) for f in (first, second)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    assert len(refused) == 2 and all("needs its own result" in text for text in refused)


def test_a_printed_number_may_have_an_exponent_or_thousands():
    assert not to_its_digits("2.50e-6").met(0.0) and to_its_digits("2.50e-6").met(2.503e-6)
    assert to_its_digits("1,250").met(1250.0) and to_its_digits("10").met(10.000000001)
