"""fuzzylite and Octave read what is written, and what fuzzylite writes is read; each runs in its own process."""

import dataclasses
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from leadscrew.fuzzy import formats
from leadscrew.fuzzy.system import INTEGRAL, System, Term
from tests.fuzzy.formats_systems import SHORT, shared, systems
from tests.tools import missing


@pytest.fixture(scope="module")
def fuzzylite():
    """A function that gives what fuzzylite makes of a text in one format, in another."""
    if shutil.which("fuzzylite") is None:
        missing("fuzzylite", "fuzzylite is not installed: apt-get install fuzzylite")

    def converted(text: str, format: str, to: str, *options: str) -> str:
        with tempfile.TemporaryDirectory() as folder:
            given, made = Path(folder, "given"), Path(folder, "made")
            given.write_text(text)
            command = ["fuzzylite", "-i", given, "-if", format, "-o", made, "-of", to, "-decimals", "17", *options]
            done = subprocess.run(command, capture_output=True, text=True, timeout=60)
            assert "error" not in done.stdout + done.stderr, done.stdout + done.stderr
            return made.read_text()

    return converted


POINTS = {"triangle": (0.0, 1.0, 0.0), "trapezoid": (0.0, 1.0, 1.0, 0.0), "ramp": (0.0, 1.0)}


def as_points(term: Term) -> Term:
    """What fuzzylite makes of a term that a .fcl file has as points or as a number."""
    xs, ys = term.parameters, POINTS.get(term.shape, ())
    if term.shape == "singleton":
        return dataclasses.replace(term, shape="constant")
    if term.shape == "ramp" and xs[1] < xs[0]:
        xs, ys = xs[::-1], (1.0, 0.0)
    if not ys or term.height != 1.0 or list(xs) != sorted(set(xs)) or xs[0] == float("-inf"):
        return term
    return Term(term.name, "discrete", tuple(v for pair in zip(xs, ys, strict=True) for v in pair))


def as_fuzzylite_has_it(system: System, format: str) -> System:
    if format == "fll":
        return system
    inputs, outputs = (
        [dataclasses.replace(v, terms=tuple(map(as_points, v.terms))) for v in side]
        for side in (system.inputs, system.outputs)
    )
    return dataclasses.replace(system, inputs=tuple(inputs), outputs=tuple(outputs))


def named_points(system: System) -> System:
    """Without what only the text of a system has: blanks in titles."""
    blocks = tuple(dataclasses.replace(b, name=b.name.strip()) for b in system.blocks)
    return dataclasses.replace(system, name=system.name.strip(), blocks=blocks, doc=system.doc.strip())


@pytest.mark.parametrize("format", ["fll", "fcl"])
@given(data=st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.reuse, Phase.generate])
def test_fuzzylite_reads_what_is_written_and_is_read_back(format, data, fuzzylite):
    system = data.draw(systems(format, SHORT, every_rule_of_sum=False))
    found = formats.loads(fuzzylite(formats.dumps(system, format), format, "fll"), "fll")
    assert named_points(found) == as_fuzzylite_has_it(system, format)


@pytest.mark.parametrize("name", ["mamdani49.fll", "mamdani49.fis", "mamdani49.fcl", "sugeno49.fll", "sugeno49.fis"])
@pytest.mark.parametrize("to", ["fll", "fis", "fcl"])
def test_a_converted_file_has_the_same_values_in_fuzzylite(name, to, fuzzylite):
    """To 1e-12 on 400 points, as fuzzylite computes the two files."""
    path = shared(f"prototypes/fuzzy/{name}")
    options = ("-values", "400", "-scope", "AllVariables", "-dheader", "false")
    before = fuzzylite(path.read_text(), path.suffix[1:], "fld", *options)
    after = fuzzylite(formats.dumps(formats.read(path), to), to, "fld", *options)
    one, two = (np.array([line.split() for line in text.splitlines()], dtype=float) for text in (before, after))
    assert one.shape[0] >= 380
    assert np.abs(one - two).max() < 1e-12


@pytest.mark.parametrize("name", ["mamdani49.fll", "sugeno49.fll"])
@pytest.mark.parametrize("to", ["fis", "fcl", "fll"])
def test_what_fuzzylite_converts_is_the_system_that_leadscrew_converts(name, to, fuzzylite):
    text = shared(f"prototypes/fuzzy/{name}").read_text()
    theirs, ours = (
        formats.loads(x, to) for x in (fuzzylite(text, "fll", to), formats.dumps(formats.loads(text, "fll"), to))
    )

    def bare(system: System) -> System:
        blocks = [dataclasses.replace(b, name="", disjunction=None) for b in system.blocks]
        outputs = [dataclasses.replace(o, integration="midpoint") for o in system.outputs]
        return dataclasses.replace(system, blocks=tuple(blocks), outputs=tuple(outputs), doc="")

    assert bare(theirs) == bare(ours)


def test_every_shape_norm_and_defuzzifier_has_fuzzylites_name(fuzzylite):
    """Of each, a file in which it stands; fuzzylite refuses a name that it does not know."""
    from leadscrew.fuzzy.formats.vocabulary import FCL_METHODS, FLL_DEFUZZIFIERS, FLL_NORMS, FLL_SHAPES
    from leadscrew.fuzzy.system import S_NORMS, SHAPES, T_NORMS

    assert set(FLL_NORMS.values()) == {*S_NORMS, *T_NORMS}
    assert set(FLL_SHAPES.values()) == set(SHAPES) - {"singleton"}
    assert set(FLL_DEFUZZIFIERS.values()) == set(FCL_METHODS.values())
    lines = ["Engine: all", "InputVariable: x", "  range: 0.0 1.0"]
    for name, shape in FLL_SHAPES.items():
        count = {"discrete": 4, "linear": 2}.get(shape, len(SHAPES[shape]))
        lines.append(f"  term: {shape} {name} {' '.join(str(0.25 * k) for k in range(count))}")
    for k, name in enumerate(FLL_DEFUZZIFIERS):
        parameter = "100" if FLL_DEFUZZIFIERS[name] in INTEGRAL else "Automatic"
        lines += [f"OutputVariable: y{k}", "  range: 0.0 1.0", f"  defuzzifier: {name} {parameter}"]
    for name, norm in FLL_NORMS.items():
        lines += [f"RuleBlock: {norm}", f"  {'conjunction' if norm in T_NORMS else 'disjunction'}: {name}"]
    system = formats.loads("\n".join(lines), "fll")
    assert formats.loads(fuzzylite(formats.dumps(system, "fll"), "fll", "fll"), "fll") == system


def test_octave_gives_a_written_file_the_values_of_the_original(tmp_path):
    """To 1e-12 on 25 points, Mamdani and Takagi-Sugeno."""
    if shutil.which("octave") is None or not list(Path("/usr/share/octave/packages").glob("fuzzy-logic-toolkit*")):
        missing("octave", "Octave is not installed with octave-fuzzy-logic-toolkit")
    lines = ["pkg load fuzzy-logic-toolkit", "[x, z] = meshgrid(linspace(-0.9, 0.9, 5));"]
    for name in ("mamdani49", "sugeno49"):
        original = shared(f"prototypes/fuzzy/{name}.fis")
        formats.write(formats.read(original), tmp_path / f"{name}.fis")
        for path in (original, tmp_path / f"{name}.fis"):
            lines.append(f"printf('%.17g ', evalfis([x(:) z(:)], readfis('{path}'))); printf('\\n');")
    (tmp_path / "compare.m").write_text("\n".join(lines))
    done = subprocess.run(
        ["octave", "-qf", "compare.m"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    rows = [line.split() for line in done.stdout.splitlines() if re.match(r"[-+0-9.]", line)]
    assert [len(row) for row in rows] == [25] * 4, done.stderr
    values = np.array(rows, dtype=float)
    assert np.abs(values[0] - values[1]).max() < 1e-12
    assert np.abs(values[2] - values[3]).max() < 1e-12
    assert np.abs(values[0] - values[2]).max() > 1e-3
