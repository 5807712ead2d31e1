"""What holds for every study: claims that are met and say why, verdicts only on what a paper says, items that exist."""

import csv
import re

import matplotlib.pyplot as plt
import pytest


def plain(study, claims):
    """Claims by their name without the study's."""
    return {c.id.removeprefix(f"{study.name}."): c for c in claims}


def assert_required_met_and_explained(result):
    missed = [(c.id, c.measured, c.sense, c.target) for c in result.claims if c.kind == "required" and not c.passed]
    assert missed == []
    assert len(result.claims) == len({c.id for c in result.claims}) == sum(n for _, n in result.topics)
    assert [c.id for c in result.claims if not (c.reason and c.source and c.statement)] == []


def assert_no_verdict_without_a_paper(result):
    assert [c.id for c in result.claims if c.paper is None and c.verdict != "cannot be checked"] == []


def assert_items_exist(study, result):
    """Every row of paper_items.csv has a place; claims and pictures that it names exist."""
    with (study.folder / "paper_items.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    claims, pictures = set(plain(study, result.claims)), {p.name for p in result.pictures}
    for row in rows:
        assert None not in row and None not in row.values(), row
        parts = [part.strip() for part in row["where"].split(";") if part.strip()]
        files = [p for p in parts if ".py" in p or p.startswith("docs/")]
        for named in files:
            path = re.split(r"[: ]", named)[0]
            assert any((root / path).exists() for root in (study.folder, *study.folder.parents[:4])), named
        names = [p for p in parts if p not in files and not p.startswith(("claim ", "claims ", "figure ", "scen"))]
        if row["covered_by"] == "claim":
            assert set(names) <= claims, (row["item"], set(names) - claims)
        if row["covered_by"] == "figure":
            assert set(names) <= pictures, (row["item"], set(names) - pictures)
        if row["covered_by"] == "none":
            assert row["status"].startswith("not done: "), row["item"]
        else:
            assert parts and row["status"].startswith("done"), row["item"]
        for named in (n.strip() for p in parts if p.startswith(("claim ", "claims ")) for n in re.split(r",| to ", p)):
            name = re.sub(r"^claims? ", "", named)
            assert name in claims or (name.endswith("*") and any(c.startswith(name[:-1]) for c in claims)), row["item"]


@pytest.mark.slow
class WholeStudy:
    """What is asked of one evaluation; the fixture ``result`` is of the test's file, and its group for xdist too."""

    study = None
    least_findings = 5
    missed = frozenset()
    """Moonshots known to be missed: said in the findings and the docs; one more, or one less, must be looked at."""
    plain_axes = frozenset()
    """Pictures that are round, or with the names of things along an axis: nothing is written there."""

    def test_every_required_claim_is_met_and_says_why(self, result):
        assert_required_met_and_explained(result)

    def test_a_claim_without_a_number_in_the_paper_gives_no_verdict_on_it(self, result):
        assert_no_verdict_without_a_paper(result)

    def test_items_point_at_claims_and_pictures_that_exist(self, result):
        assert_items_exist(self.study, result)

    def test_moonshots_are_reached_but_those_that_are_known_to_be_missed(self, result):
        claims = plain(self.study, result.claims).items()
        assert {name for name, c in claims if c.kind == "moonshot" and not c.passed} == self.missed

    def test_pictures_have_names_of_their_own_and_labelled_axes(self, result):
        names = [p.name for p in result.pictures]
        assert len(names) == len(set(names))
        assert all(p.caption for p in result.pictures)
        bare = set()
        for picture in result.pictures:
            figure = picture.draw()
            x = figure.get_supxlabel() or any(a.get_xlabel() for a in figure.axes)
            y = figure.get_supylabel() or any(a.get_ylabel() for a in figure.axes)
            bare |= set() if x and y else {picture.name}
            plt.close(figure)
        assert bare == self.plain_axes, sorted(bare ^ self.plain_axes)

    def test_every_finding_is_said_with_numbers(self, result):
        assert len(result.notes) >= self.least_findings and not any(
            re.search(r"\bnan\b|[{}]", note) for note in result.notes
        )
