"""A circular test, evaluated: quantities, reversals and diagnosis together, as a report shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from leadscrew.analysis.circular.diagnosis import Diagnosis, diagnose
from leadscrew.analysis.circular.paths import SOURCES, CircularTest
from leadscrew.analysis.circular.quantities import EDITIONS, Named, Quantities, named, quantities
from leadscrew.analysis.circular.reversals import Reversal, reversals
from leadscrew.kernel.one_thread import one_thread
from leadscrew.util.errors import ValueRefused


@dataclass(frozen=True)
class Evaluation:
    """Everything that a circular test says."""

    test: CircularTest
    edition: str
    quantities: Quantities
    reversals: list[Reversal]
    diagnosis: Diagnosis

    def named(self) -> list[Named]:
        """The quantities of the edition, by its names."""
        return named(self.quantities, self.edition, self.test.axes)

    def notes(self) -> list[str]:
        """What a reader should know before believing a number."""
        said = [*self.test.notes(), *map(str, self.diagnosis.together)]
        if not self.reversals:
            said.append("the points are too far apart to show what happens at a reversal")
        return said

    def as_dict(self) -> dict[str, Any]:
        """Plain values, with how the circle was made."""
        test = self.test
        return {
            "conditions": {
                "radius_mm": test.radius_mm,
                "feed_mm_min": test.feed_mm_min,
                "directions": [t.direction for t in test.turns],
                "axes": list(test.axes),
                "start_deg": test.start_deg,
                "sampling": test.sampling,
                "points": {t.direction: int(t.x_mm.size) for t in test.turns},
                "source": test.source,
                "source_in_words": SOURCES[test.source],
            },
            "quantities_um": [n._asdict() for n in self.named()],
            "all_um": self.quantities.as_dict(),
            "reversals": [r._asdict() for r in self.reversals],
            "diagnosis": self.diagnosis.as_dict(),
            "notes": self.notes(),
        }


@one_thread()
def evaluate(
    test: CircularTest, edition: str = "2022", leads_mm: tuple[float | None, float | None] = (None, None)
) -> Evaluation:
    """The evaluation of a test by an edition of ISO 230-4.

    Raises:
        ValueRefused: no such edition.
        DataError: a lead that the points cannot resolve.
    """
    if edition not in EDITIONS:
        raise ValueRefused(f"edition = {edition!r}: expected one of {', '.join(EDITIONS)}, the editions of ISO 230-4")
    found = diagnose(test, leads_mm)
    return Evaluation(test, edition, quantities(test), reversals(test, found.cyclic), found)
