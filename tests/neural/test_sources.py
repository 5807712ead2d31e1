"""The authors of the network's paper, wherever a module names them."""

import re

from leadscrew.catalogue import study
from tests.docs.snippets import ROOT


def test_every_module_names_the_authors_of_the_network_as_the_study_does():
    people = [name.split() for name in study("sofnn_tangent").paper.split(":")[0].split(", ")]
    initials = {surname: first[0] for first, surname in people}
    assert initials == {"Deng": "Y", "Liu": "X", "Wu": "L", "Zhang": "Q"}
    named = 0
    for file in (ROOT / "src" / "leadscrew" / "neural").glob("*.py"):
        text = " ".join(file.read_text(encoding="utf-8").split())
        for short in re.findall(r"study sofnn_tangent, ((?:[A-Z]\. \w+,? ?)+)", text):
            assert dict(x.split(". ")[::-1] for x in re.findall(r"[A-Z]\. \w+", short)) == initials, file
            named += 1
    assert named == 4
