"""Rows of fuzzy systems: in the loop, in C by hand, from Python, over arrays, and in other toolboxes.

Other fuzzy toolboxes, each asked in a process of its own by the programs of the folder ``peers`` of the repository.

Nothing of theirs is imported here. Where the folder, their environment (``make peers``, or the Python that
``LEADSCREW_PEERS`` names) or fuzzylite's headers are missing, :class:`Missing` says which.
"""

from __future__ import annotations

import ctypes
import itertools
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew.bench import measuring, probes
from leadscrew.bench.measuring import interleaved, repeated, row
from leadscrew.bench.yardstick import NoCompilerError, build
from leadscrew.fuzzy.block import function
from leadscrew.fuzzy.build import constants, triangles
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.formats import fll
from leadscrew.fuzzy.system import And, Input, Is, Output, Rule, RuleBlock, System
from leadscrew.kernel.block import controller
from leadscrew.util.errors import LeadscrewError

LABELS = ("NB", "NM", "NS", "ZE", "PS", "PM", "PB")
END = 4.0 / 3.0
"""The output's universe ends where its outer sets do."""


def mamdani(integration: str = "exact", resolution: int = 100) -> System:
    """Error and change, minimum and maximum, centroid; consequent of rule i, j: clip(i + j - 3, 0, 6)."""
    sets = triangles(LABELS, -1.0, 1.0, shoulders=False)
    e, de = Input("e", -1.0, 1.0, sets), Input("de", -1.0, 1.0, sets)
    u = Output("u", -END, END, sets, integration=integration, resolution=resolution)
    rules = tuple(
        Rule(And(Is("e", a), Is("de", b)), (Is("u", LABELS[min(6, max(0, i + j - 3))]),))
        for (i, a), (j, b) in itertools.product(enumerate(LABELS), enumerate(LABELS))
    )
    return System("mamdani49", (e, de), (u,), (RuleBlock(rules),))


def sugeno() -> System:
    """The same rules with the product, and the mean of constants."""
    made = mamdani()
    values = dict(zip(LABELS, np.linspace(-1.0, 1.0, 7).tolist(), strict=True))
    u = Output("u", -1.0, 1.0, constants(values), aggregation=None, defuzzifier="weighted_average")
    block = replace(made.blocks[0], conjunction="algebraic_product", implication=None)
    return System("sugeno49", made.inputs, (u,), (block,))


def large(integration: str = "midpoint") -> System:
    """A full rule base of 9 x 10 x 6 = 540 rules, minimum and maximum, centroid."""
    counts, name = (9, 10, 6), "abc"
    inputs = tuple(
        Input(x, -1.0, 1.0, triangles([f"{x}{k}" for k in range(n)], -1.0, 1.0))
        for x, n in zip(name, counts, strict=True)
    )
    u = Output("u", -1.25, 1.25, triangles([f"u{k}" for k in range(9)], -1.0, 1.0, shoulders=False))
    rules = tuple(
        Rule(
            And(And(Is("a", f"a{i}"), Is("b", f"b{j}")), Is("c", f"c{k}")),
            (Is("u", f"u{round((i + j + k) * 8 / 22)}"),),
        )
        for i, j, k in itertools.product(*map(range, counts))
    )
    return System("full540", inputs, (replace(u, integration=integration),), (RuleBlock(rules),))


FOLDER = Path(__file__).parents[3] / "peers"
HEADERS = Path("/usr/include/fl/Headers.h")
LONGEST = 600.0


class Missing(Exception):
    """A peer cannot be asked here, or not about this system; says why."""


class Answer(NamedTuple):
    """What a peer says."""

    ns: float
    """Processor time of one evaluation."""
    outputs: np.ndarray
    """One row a point."""
    version: str
    many_ns: float | None = None
    """Processor time a point when it is given arrays."""


def describe(system: System) -> dict[str, Any]:
    """A system of triangles with finite feet, constants or triangles on its one output, and rules that are all ``and``,
    as plain numbers.

    Raises:
        Missing: another system.
    """
    refused = Missing("takes only triangles or constants, and rules of every input joined by and")
    if len(system.outputs) != 1 or len(system.blocks) != 1:
        raise refused

    def variable(v: Any) -> dict[str, Any]:
        terms = {t.name: list(t.parameters) for t in v.terms if t.shape == "triangle"}
        if len(terms) < len(v.terms) or not np.isfinite(list(terms.values()) or 0.0).all():
            raise refused
        return {"name": v.name, "low": v.low, "high": v.high, "terms": terms}

    (output,) = system.outputs
    constants = {t.name: t.parameters[0] for t in output.terms if t.shape == "constant"}
    if constants and len(constants) < len(output.terms):
        raise refused
    names = [v.name for v in system.inputs]
    rules = []
    for rule in system.rules:
        sets, todo = {}, [rule.antecedent]
        while todo:
            node = todo.pop()
            if isinstance(node, And):
                todo += [node.left, node.right]
            elif isinstance(node, Is) and not node.hedges:
                sets[node.variable] = node.term
            else:
                raise refused
        if set(sets) != set(names) or len(rule.consequents) != 1 or rule.weight != 1.0:
            raise refused
        rules.append([[sets[n] for n in names], rule.consequents[0].term])
    plain: dict[str, Any] = {"name": output.name, "low": output.low, "high": output.high, "constants": constants}
    made = {**plain, "terms": {}} if constants else {**variable(output), "constants": {}}
    product = system.blocks[0].conjunction == "algebraic_product"
    return {"inputs": [variable(v) for v in system.inputs], "output": made, "rules": rules, "product": product}


def python() -> str:
    """The Python of the peers' environment.

    Raises:
        Missing: there is none.
    """
    named = os.environ.get("LEADSCREW_PEERS") or str(FOLDER.parent / ".peers" / "bin" / "python")
    if not FOLDER.is_dir():
        raise Missing("the folder peers is only in a clone of the repository")
    if shutil.which(named) is None:
        raise Missing("not installed: make peers")
    return named


def ask(peer: str, system: System, points: Sequence[Sequence[float]], single: int) -> Answer:
    """One of the Python peers (``pyfuzzylite``, ``simpful``, ``skfuzzy``) about a system: at the first ``single``
    points one by one, and at all of them as arrays where it takes arrays.

    Raises:
        Missing: it is not there, or fails; says why.
    """
    request = {"points": np.asarray(points, dtype=float).tolist(), "single": single}
    request |= {"fll": fll.dumps(system)} if peer == "pyfuzzylite" else {"system": describe(system)}
    command = [python(), str(FOLDER / f"{peer}_peer.py")]
    try:
        done = subprocess.run(
            command, input=json.dumps(request), capture_output=True, text=True, check=False, timeout=LONGEST
        )
    except subprocess.TimeoutExpired:
        raise Missing(f"no answer in {LONGEST:g} s") from None
    if done.returncode:
        raise Missing(f"{peer} failed: {(done.stderr.strip().splitlines() or ['no word'])[-1][:160]}")
    said = json.loads(done.stdout.strip().splitlines()[-1])
    return Answer(said["ns"], np.array(said["outputs"], dtype=float), said["version"], said.get("many_ns"))


@lru_cache(maxsize=1)
def fuzzylite_program() -> str:
    """Our program that uses fuzzylite's C++ library, compiled once a process.

    Raises:
        Missing: no compiler, or no library.
    """
    source = FOLDER / "fuzzylite.cpp"
    if not source.is_file():
        raise Missing("the folder peers is only in a clone of the repository")
    if shutil.which("g++") is None or not HEADERS.exists():
        raise Missing("not installed: Debian's libfuzzylite-dev and g++")
    made = Path(tempfile.mkdtemp(prefix="leadscrew-fuzzylite-")) / "fuzzylite"
    command = [
        "g++",
        "-std=c++11",
        "-O3",
        "-march=native",
        "-Wno-deprecated-declarations",
        str(source),
        "-o",
        str(made),
    ]
    done = subprocess.run([*command, "-lfuzzylite"], capture_output=True, text=True, check=False)
    if done.returncode:
        raise Missing(f"g++ failed: {done.stderr.strip()[:160]}")
    return str(made)


def fuzzylite(system: System, points: Sequence[Sequence[float]]) -> Answer:
    """The C++ library of fuzzylite about a system at some points.

    Raises:
        Missing: it is not there, or does not take the system.
    """
    try:
        text = fll.dumps(system)
    except LeadscrewError as error:
        raise Missing(str(error)) from None
    rows = "\n".join(" ".join(repr(float(x)) for x in point) for point in points)
    said = f"S {len(text)}\n{text}P {len(points)}\n{rows}\nT {len(points)}\n{rows}\n"
    done = subprocess.run(
        [fuzzylite_program()], input=said, capture_output=True, text=True, check=False, timeout=LONGEST
    )
    lines = done.stdout.splitlines()
    if not lines or lines[0] != "ok" or len(lines) < len(points) + 2:
        raise Missing(f"fuzzylite: {(lines or ['no answer'])[0][:160]}")
    outputs = np.array([[float(x) for x in line.split()] for line in lines[1 : len(points) + 1]])
    return Answer(float(lines[len(points) + 1]), outputs, "6")


POINTS = 20_000
NAMES = {"sugeno": "49 rules, Takagi-Sugeno", "exact": "49 rules, Mamdani", "sampled": "49 rules, Mamdani"}
HOW = {"sugeno": "active rules", "exact": "exact centroid", "sampled": "centroid of 100 midpoints"}
BOUNDS = {"sugeno": 12.0, "exact": 80.0, "sampled": None}
BY_HAND = {"sugeno": ("active", "dense"), "exact": ("exact",), "sampled": ("sampled",)}
PYTHONS = {"pyfuzzylite": ("exact", "sugeno"), "simpful": ("exact", "sugeno"), "skfuzzy": ("exact",)}


def systems() -> dict[str, System]:
    """The 49 rules in three forms."""
    return {
        "sugeno": sugeno(),
        "exact": mamdani("exact"),
        "sampled": mamdani("midpoint"),
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
    library, end = build("fuzzy.c"), END
    for name in ("none", "active", "dense", "sampled", "exact"):
        entry = getattr(library, f"fuzzy_{name}")
        entry.argtypes, entry.restype = [ctypes.POINTER(ByHand), ctypes.c_long], ctypes.c_double
    centres = np.array([t.parameters[1] for t in sugeno().inputs[0].terms])
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
    calls: dict[str, Callable[[], object]] = {"none": measuring.single(probes.probe(probes.adds), POINTS)}
    for k, system in made.items():
        calls[k] = measuring.single(in_a_loop(system), POINTS)
        calls[f"{k}, chain"] = measuring.single(in_a_loop(system, chain=True), POINTS)
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
    made = compiled(large())
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
            found = fuzzylite(forms[like], points)
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
                found = ask(peer, given, points, count)
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


WIDEST = 10.0
"""Where a universe has no end, points are drawn from this far on either side of 0."""


def points_of(system: System, count: int, seed: int = 1) -> np.ndarray:
    """Points drawn evenly from the universes of the inputs, one row a point."""
    ends = [(max(v.low, -WIDEST), min(v.high, WIDEST)) for v in system.inputs]
    low, high = np.array(ends).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(ends)))


def bench_file(system: System, points: int = 100_000, rounds: int = 5) -> list[dict[str, Any]]:
    """Rows about one system; the ratio is a peer's time over ours from Python, of arrays over ours of arrays."""
    made, at = compiled(system), points_of(system, points)
    one = at[0].tolist()
    calls: dict[str, Callable[[], object]] = {
        "one": repeated(partial(made.scalar, *one), 2000),
        "many": partial(made.many, at),
    }
    seen = interleaved(calls, rounds)
    single, arrays = seen["one"] / 2000 * 1e9, seen["many"] / points * 1e9
    name = system.name or "system"
    rules = f"{len(system.rules)} rules"
    rows = [
        measuring.row_of_load("before"),
        row(name, f"{rules}, one evaluation from Python", single / 1e3, "us"),
        row(name, f"{rules}, a point of {points:,} in arrays, one thread", arrays, "ns"),
    ]
    ours = made.many(at).reshape(points, -1)
    few = at[: min(2000, points)].tolist()
    try:
        found = fuzzylite(system, few)
        rows.append(
            row(name, "fuzzylite 6 C++, in a loop", found.ns / 1e3, "us", ratio=found.ns / arrays,
                remark=f"ratio: against ours in arrays; {_largest_difference(ours, found.outputs)}")
        )  # fmt: skip
    except Missing as why:
        rows.append(row(name, "fuzzylite 6 C++", unit="us", remark=str(why)))
    for peer in ("pyfuzzylite", "simpful", "skfuzzy"):
        rows += _python_peer(peer, system, at[:10_000].tolist(), ours, (single, arrays))
    return rows


def _python_peer(
    peer: str, system: System, points: list[list[float]], ours: np.ndarray, ns: tuple[float, float]
) -> list[dict[str, Any]]:
    name = system.name or "system"
    try:
        found = ask(peer, system, points, 20)
    except Missing as why:
        return [row(name, peer, unit="us", remark=str(why))]
    what = f"{peer} {found.version}"
    rows = [row(name, f"{what}, one evaluation", found.ns / 1e3, "us", ratio=found.ns / ns[0],
                remark=f"against ours from Python; {_largest_difference(ours, found.outputs)}")]  # fmt: skip
    if found.many_ns is not None:
        rows.append(row(name, f"{what}, in arrays", found.many_ns / 1e3, "us", ratio=found.many_ns / ns[1],
                        remark="against ours in arrays"))  # fmt: skip
    return rows


def _largest_difference(ours: np.ndarray, theirs: np.ndarray) -> str:
    both = np.abs(theirs - ours[: len(theirs)])
    told = both[np.isfinite(both)]
    return f"outputs differ by at most {told.max():.1e}" if told.size else "no output to compare"
