"""Other fuzzy toolboxes, each asked in a process of its own by the programs of the folder ``peers`` of the repository.

Nothing of theirs is imported here. Where the folder, their environment (``make peers``, or the Python that
``LEADSCREW_PEERS`` names) or fuzzylite's headers are missing, :class:`Missing` says which.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from leadscrew.fuzzy.formats import fll
from leadscrew.fuzzy.system import And, Is, System
from leadscrew.kernel.errors import LeadscrewError

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
