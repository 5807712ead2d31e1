"""Rows of fuzzy systems: in the loop, in C by hand, from Python, over arrays, and in other toolboxes."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from leadscrew.bench import entries, fuzzy_peers, fuzzy_systems, probes
from leadscrew.bench.fuzzy_peers import Missing
from leadscrew.bench.row import row
from leadscrew.bench.timing import interleaved, repeated
from leadscrew.bench.yardstick import NoCompilerError, build
from leadscrew.fuzzy.block import function
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.system import System
from leadscrew.kernel.block import controller

POINTS = 20_000
NAMES = {"sugeno": "49 rules, Takagi-Sugeno", "exact": "49 rules, Mamdani", "sampled": "49 rules, Mamdani"}
HOW = {"sugeno": "active rules", "exact": "exact centroid", "sampled": "centroid of 100 midpoints"}
BOUNDS = {"sugeno": 12.0, "exact": 80.0, "sampled": None}
BY_HAND = {"sugeno": ("active", "dense"), "exact": ("exact",), "sampled": ("sampled",)}
PYTHONS = {"pyfuzzylite": ("exact", "sugeno"), "simpful": ("exact", "sugeno"), "skfuzzy": ("exact",)}


def systems() -> dict[str, System]:
    """The 49 rules in three forms."""
    return {
        "sugeno": fuzzy_systems.sugeno(),
        "exact": fuzzy_systems.mamdani("exact"),
        "sampled": fuzzy_systems.mamdani("midpoint"),
    }


def in_a_loop(system: System, chain: bool = False) -> Any:
    """A compiled loop that asks the system once a period; ``chain``: at a point that waits for the last output."""
    infer = function(system)

    @controller(probes.Total(), probes.Total())
    def fires(p, s, command):
        return s, infer(command.x, command.y)

    @controller(probes.Total(), probes.Total())
    def waits(p, s, command):
        out = infer(command.x + 1e-3 * s.sum, command.y)
        return probes.Total(out), out

    return probes.probe(waits if chain else fires)


class ByHand(ctypes.Structure):
    """Mirrors ``Fuzzy`` of ``c/fuzzy.c``."""

    _fields_ = (
        ("centres", ctypes.c_double * 7), ("over", ctypes.c_double * 6), ("table", ctypes.c_double * 49),
        ("low", ctypes.c_double), ("high", ctypes.c_double), ("width", ctypes.c_double),
        ("consequent", ctypes.c_int * 49), ("nodes", ctypes.c_double * 100), ("sets", ctypes.c_double * 700),
    )  # fmt: skip


def by_hand() -> tuple[ctypes.CDLL, ByHand]:
    """The library, and the numbers of the 49 rules.

    Raises:
        NoCompilerError: no gcc.
    """
    library, end = build("fuzzy.c"), fuzzy_systems.END
    for name in ("none", "active", "dense", "sampled", "exact"):
        entry = getattr(library, f"fuzzy_{name}")
        entry.argtypes, entry.restype = [ctypes.POINTER(ByHand), ctypes.c_long], ctypes.c_double
    centres = np.array([t.parameters[1] for t in fuzzy_systems.sugeno().inputs[0].terms])
    consequent = np.clip(np.add.outer(np.arange(7), np.arange(7)) - 3, 0, 6).ravel()
    nodes = -end + (np.arange(100) + 0.5) * (2.0 * end / 100)
    width = centres[1] - centres[0]
    sets = np.clip(1.0 - np.abs(nodes - centres[:, None]) / width, 0.0, 1.0)
    made = ByHand(low=-end, high=end, width=width)
    values = np.linspace(-1.0, 1.0, 7)[consequent]
    for field, numbers in (("centres", centres), ("over", 1.0 / np.diff(centres)), ("table", values), ("nodes", nodes)):
        getattr(made, field)[:] = numbers.tolist()
    made.sets[:], made.consequent[:] = sets.ravel().tolist(), consequent.tolist()
    return library, made


def loop_rows(rounds: int) -> tuple[list[dict[str, Any]], dict[str, float]]:
    """What a system costs in a compiled loop, beside C by hand; also nanoseconds by form."""
    made = systems()
    calls: dict[str, Callable[[], object]] = {"none": entries.single(probes.probe(probes.adds), POINTS)}
    for k, system in made.items():
        calls[k] = entries.single(in_a_loop(system), POINTS)
        calls[f"{k}, chain"] = entries.single(in_a_loop(system, chain=True), POINTS)
    why = ""
    try:
        library, numbers = by_hand()
        for name in ("none", "active", "dense", "sampled", "exact"):
            calls[f"C {name}"] = partial(getattr(library, f"fuzzy_{name}"), numbers, POINTS)
    except NoCompilerError as error:
        why = str(error)
    seen = {k: v / POINTS * 1e9 for k, v in interleaved(calls, rounds).items()}
    ours = {k: v - seen["none"] for k, v in seen.items() if not k.startswith("C ")}
    rows = []
    for k in made:
        rows.append(row(NAMES[k], f"{HOW[k]}, marginal cost in the loop", ours[k], "ns", at_most=BOUNDS[k]))
        rows.append(row(NAMES[k], f"{HOW[k]}, each point waits for the last output", ours[f"{k}, chain"], "ns"))
        for name in BY_HAND[k]:
            theirs = seen[f"C {name}"] - seen["C none"] if not why else None
            rows.append(
                row(NAMES[k], f"C by hand, {'all rules' if name == 'dense' else HOW[k]}", theirs, "ns",
                    ratio=None if theirs is None else theirs / ours[k], remark=why or "ratio: theirs over ours")
            )  # fmt: skip
    return rows, ours


def python_rows(rounds: int) -> tuple[list[dict[str, Any]], dict[str, float], dict[str, float]]:
    """One evaluation from Python, and a point of arrays; also nanoseconds by form."""
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (10_000, 2))
    one: dict[str, Callable[[], object]] = {}
    many: dict[str, Callable[[], object]] = {}
    for k, system in systems().items():
        made = compiled(system)
        one[k], many[k] = repeated(partial(made.scalar, 0.3, -0.2), 2000), partial(made.many, points)
    scalar = {k: v / 2000 * 1e9 for k, v in interleaved(one, rounds).items()}
    arrays = {k: v / len(points) * 1e9 for k, v in interleaved(many, rounds).items()}
    rows = [
        row(NAMES[k], f"{HOW[k]}, one evaluation from Python", v / 1e3, "us", at_most=2.0) for k, v in scalar.items()
    ]
    rows += [row(NAMES[k], f"{HOW[k]}, a point of 10,000 in arrays", v, "ns") for k, v in arrays.items()]
    return rows, scalar, arrays


def large_row(points: int) -> dict[str, Any]:
    """A million points of 540 rules."""
    made = compiled(fuzzy_systems.large())
    at = np.random.default_rng(1).uniform(-1.0, 1.0, (points, 3))
    made.many(at[:1000])
    began = time.perf_counter()
    made.many(at)
    seconds = time.perf_counter() - began
    what = f"general path, centroid of 100 midpoints, {points:,} points on one thread"
    remark = f"{seconds / points * 1e9:.0f} ns a point"
    at_most = 2.0 if points >= 1_000_000 else None
    return row("540 rules, three inputs", what, seconds, "s", at_most=at_most, remark=remark)


def fuzzylite_rows(ours: dict[str, float], points: Sequence[Sequence[float]]) -> list[dict[str, Any]]:
    """One evaluation of fuzzylite in C++ against ours in the loop."""
    forms = systems()
    rows = []
    for k, like, bound in (("exact", "sampled", 50.0), ("sampled", "sampled", None), ("sugeno", "sugeno", 150.0)):
        what = f"fuzzylite 6 C++, its {HOW[like]}, against our {HOW[k]}" if k != "sugeno" else "fuzzylite 6 C++"
        try:
            found = fuzzy_peers.fuzzylite(forms[like], points)
        except Missing as why:
            rows.append(row(NAMES[k], what, unit="ns", remark=str(why)))
            continue
        remark = _apart(forms[k], points, found.outputs)
        rows.append(row(NAMES[k], what, found.ns, "ns", ratio=found.ns / ours[k], at_least=bound, remark=remark))
    return rows


def peer_rows(
    ours: dict[str, float], scalar: dict[str, float], arrays: dict[str, float], count: int
) -> list[dict[str, Any]]:
    """The toolboxes in Python."""
    points = np.random.default_rng(2).uniform(-0.95, 0.95, (10_000, 2)).tolist()
    forms, rows = systems(), []
    for peer, about in PYTHONS.items():
        for k in about:
            given = forms["sampled" if k == "exact" else k]
            try:
                found = fuzzy_peers.ask(peer, given, points, count)
            except Missing as why:
                rows.append(row(NAMES[k], peer, unit="us", remark=str(why)))
                continue
            remark = (
                f"against our {HOW[k]} in the loop; {found.ns / scalar[k]:,.0f} x against ours called from Python; "
                f"{_apart(forms[k], points[:count], found.outputs)}"
            )
            what = f"{peer} {found.version}, one evaluation"
            rows.append(
                row(NAMES[k], what, found.ns / 1e3, "us", ratio=found.ns / ours[k], at_least=1000.0, remark=remark)
            )
            if found.many_ns is not None:
                like = "sampled" if k == "exact" else k
                what = f"{peer} {found.version}, a point of {len(points):,} in arrays"
                rows.append(
                    row(NAMES[k], what, found.many_ns, "ns", ratio=found.many_ns / arrays[like], at_least=10.0,
                        remark=f"against our {HOW[like]} in arrays")
                )  # fmt: skip
    return rows


def _apart(system: System, points: Any, outputs: np.ndarray) -> str:
    """How far a peer's outputs are from ours."""
    ours = compiled(system).many(points)
    return f"outputs differ by at most {float(np.nanmax(np.abs(outputs[:, 0] - ours))):.1e}"


def rows(rounds: int, quick: bool = False) -> list[dict[str, Any]]:
    """All rows of this file."""
    loops, ours = loop_rows(rounds)
    pythons, scalar, arrays = python_rows(rounds)
    points = np.random.default_rng(3).uniform(-1.0, 1.0, (2_000 if quick else 10_000, 2)).tolist()
    return [
        *loops,
        *pythons,
        large_row(100_000 if quick else 1_000_000),
        *fuzzylite_rows(ours, points),
        *peer_rows(ours, scalar, arrays, 20 if quick else 200),
    ]
