"""What the study grey_turning asks of its guard: acceptance 5, and what the digest says of a hard spot."""

import pytest

from leadscrew.studies.grey_turning.claims_guard import guard_claims
from leadscrew.studies.grey_turning.figures_guard import guard_pictures
from leadscrew.studies.grey_turning.runs import Loops


@pytest.mark.slow
def test_every_claim_on_the_guard_holds_and_every_picture_is_drawn():
    loops = Loops()
    claims = guard_claims(loops)
    assert len({c.id for c in claims}) == len(claims) > 20
    assert [(c.id, c.measured, c.target) for c in claims if c.passed is False] == []
    assert all(c.reason and c.source and c.statement for c in claims)
    assert all(picture.draw().axes for picture in guard_pictures(loops))
