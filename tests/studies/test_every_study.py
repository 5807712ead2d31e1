"""Every study as its report prints it: whole, with each number expected and met, and each item of the paper covered."""

import csv
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from leadscrew import catalogue, resolve
from leadscrew.studies import results
from tests.fuzzy.formats_systems import shared

STUDIES, DOCS = list(catalogue.STUDIES), Path(__file__).parents[2] / "docs"


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(newline="", encoding="utf-8") as text:
        return list(csv.DictReader(text))


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.xdist_group(f"whole {n}")) for n in STUDIES])
def test_every_number_of_the_whole_study_is_expected_and_met(name):
    study, done = resolve.study(name), []
    found = results.evaluate(study, lambda what, share: done.append(share))
    assert done == sorted(done) and done[-1] == 1.0
    assert found.missed == []
    assert set(found.values()) == set(results.expected(study.folder))
    assert [c.id for c in found.claims if not c.note and c.verdict != "reproduced"] == []
    for picture in found.figures:
        drawn = picture.draw(found.lab)
        labels = [t for axes in drawn.axes for t in (axes.get_xlabel(), axes.get_ylabel()) if t]
        assert labels and all("(" in t for t in labels), picture.name
        plt.close(drawn)
    writer = runpy.run_path(str(DOCS / "generate.py"))
    if writer["kept"]():  # in CI: the page is written of the same evaluation
        writer["write_study"](DOCS, study, found)


@pytest.mark.parametrize("name", STUDIES)
def test_every_number_beside_one_of_the_paper_is_what_it_was_before_this_form(name):
    """``baseline/NAME.csv`` says where each number of the study's first form is now, or why it changed or is gone."""
    now = results.expected(resolve.study(name).folder)
    rows = rows_of(Path(__file__).with_name("baseline") / f"{name}.csv")
    before = {
        r["id"].removeprefix(f"{name}."): r["measured"] for r in rows_of(shared(f"baseline/{name}.csv")) if r["paper"]
    }
    assert {r["before"] for r in rows} == set(before)
    for row in rows:
        was, is_now = before[row["before"]], row["now"] and now[row["now"]][0]
        if not row["now"]:
            assert row["dropped because"]
        elif row.get("changed because"):
            assert is_now
        elif is_now == "inf":
            assert was in ("no", ""), row
        else:
            assert is_now == was or float(is_now) == pytest.approx(float(was), rel=1e-9, abs=1e-12), row


@pytest.mark.parametrize("name", STUDIES)
def test_items_of_the_paper_and_claims_name_each_other(name):
    study = resolve.study(name)
    rows, contents = rows_of(study.folder / "paper_items.csv"), study.contents()
    assert {item for c in contents.claims for item in c.items} == {
        r["item"] for r in rows if r["covered_by"] == "claim"
    }
    shown = {e.name for e in contents.experiments} | {f.name for f in contents.figures}
    for row in rows:
        assert row["what"] and row["section"] and row["kind"]
        if row["covered_by"] in ("figure", "experiment"):
            assert set(row["where"].split("; ")) <= shown, row["item"]
        if row["covered_by"] in ("code", "data"):
            for file in (part.partition(":")[0] for part in row["where"].split("; ")):
                assert any((root / file).exists() for root in (study.folder, *study.folder.parents[:2])), row
        assert row["status"].startswith("not done: ") == (row["covered_by"] == "none"), row


@pytest.mark.parametrize("name", STUDIES)
def test_ten_to_twelve_key_claims_and_a_conclusion_of_three_sentences_at_most_make_the_summary(name):
    found = results.evaluate(resolve.study(name), key=True)
    assert found.missed == [] and 10 <= len(found.claims) <= 12 and all(c.key for c in found.claims)
    assert 1 <= len(found.conclusion) <= 4 and not any("nan" in sentence for sentence in found.conclusion)
