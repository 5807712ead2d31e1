"""Published systems, from the files in which they were published, give what other programs give; and survive files."""

import re
import shutil
import subprocess
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.evaluate import compiled
from leadscrew.fuzzy.system import And, Is, Or, System
from leadscrew.util.errors import ValueRefused
from tests.fuzzy.formats_systems import shared
from tests.fuzzy.oracle import generator
from tests.fuzzy.oracle.fuzzylite import Fuzzylite
from tests.fuzzy.systems import mamdani, sugeno, with_output
from tests.tools import missing

CLOSE = 1e-9


def tipper(**output) -> System:
    """The tipper of MATLAB's toolbox."""
    return with_output(formats.read(shared("data/fuzzy/tipper.fis")), **output)


def markup_tipper(**output) -> System:
    """The tipper of IEEE 1855."""
    return with_output(formats.read(shared("data/fuzzy/tipper.xml")), **output)


def crane() -> System:
    """The container crane of IEC 61131-7, without the rule that names a term that does not exist."""
    return formats.read(shared("data/fuzzy/container_crane.fcl"), leave_out_unknown=True)


def random_points(system: System, count: int, beyond: float = 0.0) -> np.ndarray:
    """Points all over the universes, and beyond them by a part of their width."""
    ends = [(v.low, v.high, beyond * (v.high - v.low)) for v in system.inputs]
    rng = np.random.default_rng(20)
    return rng.uniform([low - w for low, _, w in ends], [high + w for _, high, w in ends], (count, len(ends)))


def same_in_fuzzylite(system: System, points: np.ndarray, text: str, format: str) -> np.ndarray:
    """Our outputs, which are fuzzylite's for a file to 1e-9, NaN for NaN."""
    ours = compiled(system).many(points)
    with Fuzzylite() as peer:
        peer.load(text, format)
        theirs = peer.evaluate(points)[:, 0]
    assert np.array_equal(np.isnan(ours), np.isnan(theirs))
    print(f"{format}: largest difference {np.nanmax(np.abs(ours - theirs)):.3g}")
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=CLOSE)
    return ours


def test_the_tipper_is_fuzzylites_at_1000_points():
    """From the published file by fuzzylite's own reader, and from each of our three."""
    system = tipper(integration="midpoint")
    points = random_points(system, 1000, beyond=0.1)
    published = shared("data/fuzzy/tipper.fis").read_text()
    ours = [same_in_fuzzylite(system, points, published, "fis")]
    ours += [same_in_fuzzylite(system, points, formats.dumps(system, f), f) for f in formats.WRITTEN]
    assert np.ptp(ours[0]) > 15.0


@pytest.mark.parametrize("resolution", [17, 1000])
def test_the_tipper_is_fuzzylites_at_other_resolutions(resolution):
    system = tipper(integration="midpoint", resolution=resolution)
    same_in_fuzzylite(system, random_points(system, 200), formats.dumps(system, "fll"), "fll")


def test_the_markup_tipper_is_fuzzylites_at_1000_points():
    """There it is read from the files that it was converted to, as fuzzylite reads no markup."""
    system = markup_tipper()
    points = random_points(system, 1000, beyond=0.1)
    for format in ("fll", "fcl"):
        assert np.ptp(same_in_fuzzylite(system, points, formats.dumps(system, format), format)) > 9.0


def test_the_crane_is_fuzzylites_at_1000_points():
    """From a copy of the published file without the broken rule, and from ours."""
    system = crane()
    points = random_points(system, 1000, beyond=0.1)
    lines = shared("data/fuzzy/container_crane.fcl").read_text().splitlines()
    kept = [line for line in lines if "IS pos_big" not in line]
    assert len(kept) == len(lines) - 1
    # fuzzylite 6 wants a blank before the colon, and leaves out rules in capitals without a word
    published = "\n".join(kept).replace("AND:", "AND :")
    published = re.sub(r" (IF|IS|AND|THEN)(?= )", lambda word: word[0].lower(), published)
    ours = same_in_fuzzylite(system, points, published, "fcl")
    for format in ("fll", "fcl"):
        same_in_fuzzylite(system, points, formats.dumps(system, format), format)
    assert 200 < np.isfinite(ours).sum() < 800
    assert np.nanmin(ours) < -11.9
    assert np.nanmax(ours) > 11.9


def in_octave(folder: Path, points: np.ndarray, *paths: Path) -> np.ndarray:
    """What Octave's ``evalfis`` gives for files at points, on 101 nodes: one row a file."""
    if shutil.which("octave") is None or not list(Path("/usr/share/octave/packages").glob("fuzzy-logic-toolkit*")):
        missing("octave", "Octave is not installed with octave-fuzzy-logic-toolkit")
    np.savetxt(folder / "points.csv", points, fmt="%.17g", delimiter=",")
    lines = ["pkg load fuzzy-logic-toolkit", "x = dlmread('points.csv', ',');"]
    lines += [f"printf('%.17g ', evalfis(x, readfis('{path}'), 101)); printf('\\n');" for path in paths]
    (folder / "run.m").write_text("\n".join(lines) + "\n")
    done = subprocess.run(
        ["octave", "-qf", "run.m"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    rows = [line.split() for line in done.stdout.splitlines() if re.match(r"[-+0-9.NIa]", line)]
    assert [len(row) for row in rows] == [len(points)] * len(paths), done.stderr
    return np.array(rows, dtype=float)


def test_the_tipper_is_octaves_at_100_points(tmp_path):
    """From the published file, to which Octave wants a version added, and from ours; the trapezoid rule, 101 nodes."""
    text = shared("data/fuzzy/tipper.fis").read_text()
    (tmp_path / "published.fis").write_text(text.replace("NumInputs", "Version=2.0\nNumInputs", 1))
    formats.write(tipper(), tmp_path / "written.fis")
    points = random_points(tipper(), 100)
    ours = compiled(tipper()).many(points)
    theirs = in_octave(tmp_path, points, tmp_path / "published.fis", tmp_path / "written.fis")
    print(f"largest difference {np.abs(theirs - ours).max():.3g}")
    np.testing.assert_allclose(theirs, [ours, ours], rtol=0, atol=CLOSE)
    assert np.abs(ours - compiled(tipper(integration="midpoint")).many(points)).max() > 1e-6


PUBLISHED = {"tipper of MATLAB": tipper, "tipper of IEEE 1855": markup_tipper, "crane": crane}
SMALL = {
    "mamdani": mamdani,
    "mamdani, exact": lambda: mamdani(integration="exact"),
    "mamdani, bisector": lambda: mamdani(defuzzifier="bisector", resolution=77),
    "sugeno": sugeno,
    "sugeno, held": lambda: sugeno(lock_previous=True, default=0.0),
}


def plainer(system: System) -> System:
    """The system without what most formats lack: heights, defaults, held values and ranges, activations, two blocks."""

    def flat(node: And | Or | Is) -> And | Or | Is:
        if isinstance(node, Is):
            return replace(node, hedges=tuple(h for h in node.hedges if h in ("not", "very", "any"))[:1])
        return And(flat(node.left), flat(node.right))

    block = system.blocks[0]
    rules = tuple(
        replace(r, antecedent=flat(r.antecedent), consequents=tuple(replace(c, hedges=()) for c in r.consequents))
        for r in block.rules
    )
    block = replace(block, rules=rules, activation="general", activation_parameters=(), implication="algebraic_product")
    first = system.outputs[0]
    common = {
        "default": float("nan"), "lock_previous": False, "lock_range": False, "aggregation": first.aggregation,
        "defuzzifier": first.defuzzifier,
    }  # fmt: skip

    def terms(v):
        return tuple(replace(t, height=1.0) for t in v.terms)

    inputs = tuple(replace(v, lock_range=False, enabled=True, terms=terms(v)) for v in system.inputs)
    outputs = tuple(replace(o, **common, terms=terms(o)) for o in system.outputs)
    return replace(system, inputs=inputs, outputs=outputs, blocks=(block,))


def through_files(name: str, system: System, found: Counter) -> None:
    """Through every format that can express a system: outputs at 200 points are the same to 1e-12."""
    points = generator.points(system, 200, 3)
    before = compiled(system, "python").many(points)
    for format in formats.WRITTEN:
        try:
            text = formats.dumps(system, format)
        except ValueRefused:
            found[format, "refused"] += 1
            continue
        found[format, "written"] += 1
        after = compiled(formats.loads(text, format), "python").many(points)
        assert np.array_equal(np.isnan(before), np.isnan(after)), f"{name}, {format}"
        np.testing.assert_allclose(after, before, rtol=0, atol=1e-12, err_msg=f"{name}, {format}")


@pytest.mark.slow
def test_published_and_small_systems_keep_their_outputs_through_files():
    found: Counter = Counter()
    for name, made in {**PUBLISHED, **SMALL}.items():
        through_files(name, made(), found)
    print(dict(found))
    assert found["fll", "written"] == found["fcl", "written"] == 8
    # a .fis file has no default and no held value
    assert (found["fis", "written"], found["fis", "refused"]) == (6, 2)


def generated(seeds: range) -> tuple[Counter, Counter]:
    """What was found of generated systems, and of the same without what most formats lack."""
    found: Counter = Counter()
    plain: Counter = Counter()
    for seed in seeds:
        system = generator.system(seed)
        through_files(f"system {seed}", system, found)
        through_files(f"plainer system {seed}", plainer(system), plain)
    print(dict(found), dict(plain))
    return found, plain


@pytest.mark.slow
def test_generated_systems_keep_their_outputs_through_files():
    found, plain = generated(range(4))
    assert found["fll", "written"] == plain["fll", "written"] == plain["fcl", "written"] == 4
    assert plain["fis", "written"] >= 3


@pytest.mark.slow
def test_forty_generated_systems_keep_their_outputs_through_files():
    found, plain = generated(range(100, 140))
    assert found["fll", "written"] == plain["fll", "written"] == plain["fcl", "written"] == 40
    assert found["fcl", "written"] >= 12
    assert plain["fis", "written"] >= 25
