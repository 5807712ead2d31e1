"""What a paper says, as functions that measure it: ``@claim``, its columns, and the verdict that follows from them.

A claim is one function; its docstring is the statement, what it returns are the numbers::

    @claim("Figure 12", "figure 12", says="2.0", unit="um", basis="reconstructed plant", holds=at_most(2.0))
    def error_after_2_s(lab):
        "largest error for t > 2 s"
        return Measured(printed=..., corrected=..., note="within half a count of the grating")
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from leadscrew.util.errors import BlockError

if TYPE_CHECKING:
    from leadscrew.studies.lab import Lab

SCHEMA_VERSION = 2

Value = float | int | str | bool | None
Basis = Literal["arithmetic", "paper's data", "printed plant", "reconstructed plant", "fitted"]
Verdict = Literal["reproduced", "reproduced with a change", "fitted", "not reproduced", "not testable here"]
VERDICTS: tuple[Verdict, ...] = (
    "reproduced",
    "reproduced with a change",
    "fitted",
    "not reproduced",
    "not testable here",
)


class Test(NamedTuple):
    """When a number meets the paper's statement: the rule in words, and as a function."""

    text: str
    met: Callable[[Any], bool]


def at_most(limit: float) -> Test:
    """The value is ``limit`` or less."""
    return Test(f"≤ {limit:g}", lambda value: value <= limit)


def at_least(limit: float) -> Test:
    """The value is ``limit`` or more."""
    return Test(f"≥ {limit:g}", lambda value: value >= limit)


def within(target: float, tolerance: float) -> Test:
    """The value differs from ``target`` by ``tolerance`` at most."""
    return Test(f"{target:g} ± {tolerance:g}", lambda value: abs(value - target) <= tolerance)


def equals(target: Value) -> Test:
    """The value is ``target``, exactly."""
    return Test(f"= {target:g}" if isinstance(target, float) else f"= {target}", lambda value: value == target)


def to_its_digits(says: str) -> Test:
    """The value is the printed number, to half a unit of its last digit; a whole number exactly."""
    printed = Decimal(says.replace(",", "").replace("−", "-"))
    exponent = int(printed.as_tuple().exponent)
    slack = 1e-9 * abs(float(printed)) if exponent == 0 else 0.5 * 10.0**exponent * (1.0 + 1e-9)
    return within(float(printed), slack)


class Measured(NamedTuple):
    """What a claim measures: one number for the system as printed, one with the corrections, one for our own.

    A column that does not apply stays None.
    """

    printed: Value = None
    corrected: Value = None
    ours: Value = None
    note: str = ""
    """Why: what the reader has to know beside the numbers."""
    says: str | None = None
    """What the paper says, where it differs from case to case."""
    holds: Test | list[bool] | None = None
    """The test, where it differs from case to case; or whether each column passes it, by what the note says."""

    @classmethod
    def of(cls, columns: Iterable[Value], **rest: Any) -> Measured:
        """What is measured, its columns in their order."""
        printed, corrected, ours = (*columns, None, None, None)[:3]
        return cls(printed, corrected, ours, **rest)


@dataclass(frozen=True)
class Claim:
    """One statement of the paper beside what was measured."""

    id: str
    items: tuple[str, ...]
    """Rows of ``paper_items.csv`` that it tests."""
    source: str
    """Where the paper says it."""
    basis: Basis
    statement: str
    says: str
    unit: str
    as_printed: Value
    corrected: Value
    ours: Value
    test: str
    verdict: Verdict
    note: str
    key: bool = False

    def columns(self) -> dict[str, Value]:
        """The columns that have a value, by name."""
        named = {"as printed": self.as_printed, "corrected": self.corrected, "ours": self.ours}
        return {name: value for name, value in named.items() if value is not None}

    def as_dict(self) -> dict[str, Any]:
        """The claim for JSON."""
        return {**vars(self), "items": list(self.items), "schema_version": SCHEMA_VERSION}


def verdict_of(basis: Basis, measured: Measured, test: Test) -> Verdict:
    """The verdict on a statement, by the columns that pass its test.

    As printed: *reproduced*; only with the corrections: *with a change*; what was fitted to the statement never counts
    as reproduced; and where neither the printed nor the corrected system gives a number it is not testable here.
    """
    columns = measured[:3]
    if isinstance(measured.holds, list):
        printed, corrected, ours = (*measured.holds, False, False, False)[:3]
    else:
        printed, corrected, ours = (value is not None and bool(test.met(value)) for value in columns)
    if basis == "fitted":
        return "fitted" if printed or corrected or ours else "not reproduced"
    if measured.printed is None and measured.corrected is None:
        return "not testable here"
    return "reproduced" if printed else "reproduced with a change" if corrected else "not reproduced"


@dataclass(frozen=True)
class ClaimOf:
    """A claim of a study before it is judged: what ``@claim`` makes of a function."""

    measure: Callable[..., Measured]
    source: str
    items: tuple[str, ...]
    says: str
    unit: str
    basis: Basis
    over: Mapping[str, Any]
    holds: Test | None
    key: bool

    @property
    def name(self) -> str:
        """The function's."""
        return self.measure.__name__

    def judged(self, lab: Lab) -> list[Claim]:
        """The claim, once for each case of ``over``."""
        return list(self._judged(lab))

    def _judged(self, lab: Lab) -> Iterator[Claim]:
        for case, argument in self.over.items() or (("", None),):
            measured = self.measure(lab, argument) if case else self.measure(lab)
            if not isinstance(measured, Measured):
                raise BlockError(f"{lab.study.name}: {self.name} returned {measured!r}; expected Measured(...)")
            says = self.says if measured.says is None else measured.says
            own = Test("as the note says", bool) if isinstance(measured.holds, list) else measured.holds
            test = own or self.holds or _test_of(says)
            words = (self.measure.__doc__ or self.name).strip()
            words = words.format(case=argument) if case else words
            printed, corrected, ours = map(_plain, measured[:3])
            yield Claim(
                id=".".join(filter(None, (lab.study.name, self.name, case))),
                items=self.items,
                source=self.source,
                basis=self.basis,
                statement=words,
                says=says,
                unit=self.unit,
                as_printed=printed,
                corrected=corrected,
                ours=ours,
                test=test.text,
                verdict=verdict_of(self.basis, measured, test),
                note=measured.note,
                key=self.key,
            )


def _plain(value: Any) -> Value:
    plain: Value = value.item() if hasattr(value, "item") else value
    return "yes" if plain is True else "no" if plain is False else plain


def _test_of(says: str) -> Test:
    try:
        return to_its_digits(says)
    except (ArithmeticError, TypeError, ValueError):
        return Test(f"= {says}", lambda value: (value == says) or (says == "yes" and value is True))


def claim(
    source: str,
    *items: str,
    says: str = "yes",
    unit: str = "",
    basis: Basis,
    over: Mapping[str, Any] | None = None,
    holds: Test | None = None,
    key: bool = False,
) -> Callable[[Callable[..., Measured]], ClaimOf]:
    """Makes a function a claim of the study in whose module it stands.

    Args:
        source: where the paper says it: equation, figure, section.
        items: rows of ``paper_items.csv`` that this tests.
        says: what the paper says, as it prints it.
        unit: of the columns, in ASCII.
        basis: what the numbers rest on.
        over: cases by the name that each adds to the claim's id; the function gets the case, its docstring ``{case}``.
        holds: when the statement is met; unless given, a number is met to half a unit of its last printed digit, and
            a text by the same text.
        key: whether it is one of the ten or so that the summary and the demo show.
    """

    def made(function: Callable[..., Measured]) -> ClaimOf:
        return ClaimOf(function, source, items, says, unit, basis, over or {}, holds, key)

    return made


def finite(value: float) -> float | None:
    """The value, or None where it is not finite: what was never reached has no number."""
    return value if math.isfinite(value) else None
