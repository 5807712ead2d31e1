"""The negative control: one gain that acts, one ulp off in the exported artefact, and every check says so."""

import dataclasses
import math
import re

import numpy as np
import pytest

from leadscrew.export import fmu, hal
from leadscrew.export.folder import TARGETS, compiler_path, verify
from leadscrew.export.source import Source
from leadscrew.export.verdict import DIFFERENT, IDENTICAL, NOT_RUN
from tests.export.table import complete, exported, folder_of, loop_of

QUICK = {("vud_beta_e", "hal"), ("npid", "c99"), ("smc", "fmu3")}
CELLS = [
    pytest.param(row, target, marks=() if (row, target) in QUICK else pytest.mark.slow, id=f"{row}-{target}")
    for row in ("vud_beta_e", "npid", "smc")
    for target in TARGETS
]


def replayed(loop, inputs, changes):
    """What the controller gives for recorded inputs in plain Python, its parameters changed."""
    loop = loop.using({f"controller.{key}": value for key, value in changes.items()})
    block = loop.blocks["controller"]
    p, s = loop.prepared(block, "controller"), loop.start_state(block)
    source = Source(block, p, s, loop.signals, name="x", period=loop.period, real="double", head="")
    step = source.module.namespace()[source.step]
    out = []
    for row in inputs.tolist():
        given = dict(zip((a.key for a in source.inputs), row, strict=True))
        s, u = step(p, s, *(loop.period if n == "dt" else source.filled(n, given, float) for n in block.signals))
        out.append(source.numbers(u))
    return np.array(out)


def acting_gain(row):
    """A gain of the record: its knob, and its value one ulp up. Both 1e-9 and one ulp of it change outputs."""
    core, record = exported(row)
    loop, golden = loop_of(row), core.machine_outputs(record)
    assert (replayed(loop, record.inputs, {}) == record.outputs).all()

    def acts(knob, value):
        changed = dataclasses.replace(record, outputs=replayed(loop, record.inputs, {knob.key: value}))
        return bool((core.machine_outputs(changed) != golden).any())

    for knob in core.knobs:
        if knob.kind == "float" and knob.value > 0.0:
            up = math.nextafter(knob.value, math.inf)
            if acts(knob, knob.value * (1.0 + 1e-9)) and acts(knob, up):
                return knob, up
    raise AssertionError(f"no gain of {row} acts")


def in_c(text, name, knob, value):
    """``NAME.c`` with another default."""
    at = text.index(f"void {name}_defaults")
    for place in knob.places:
        here = at
        for part in place.split("."):
            here = text.index(f".{part} = ", here)
        start = text.index("= ", here) + 2
        end = text.index(",", start)
        assert float(text[start:end]) == knob.value
        text = f"{text[:start]}{value!r}{text[end:]}"
    return text


def spoil(folder, target, core, record, knob, value):
    """Changes one default of an exported controller."""
    code = folder / f"{core.name}.c"
    if target == "c99":
        code.write_text(in_c(code.read_text(), core.name, knob, value))
    elif target == "hal":
        comp = folder / f"{core.name}.comp"
        pin = hal.parameters([k.name for k in core.knobs], [])[core.knobs.index(knob)]
        text, count = re.subn(rf"(param rw float {pin} = )\S+", rf"\g<1>{value!r}", comp.read_text())
        assert count == 1
        comp.write_text(text)
    else:
        files = core.files | {code.name: in_c(core.files[code.name], core.name, knob, value)}
        unit = fmu.build(dataclasses.replace(core, files=files), int(target[-1]), compiler_path(), record)
        (folder / f"{core.name}.fmu").write_bytes(unit)


@pytest.mark.parametrize(("row", "target"), CELLS)
def test_one_gain_one_ulp_off_is_found(row, target, tmp_path):
    folder = folder_of(row, target, tmp_path)
    core, record = exported(row)
    knob, value = acting_gain(row)
    assert value - knob.value == math.ulp(knob.value)
    spoil(folder, target, core, record, knob, value)
    found = verify(folder)
    judged = [v for v in found if v.verdict != NOT_RUN]
    spoilt = [v for v in judged if target != "hal" or v.target.startswith("hal")]
    assert {v.verdict for v in spoilt} <= {DIFFERENT}
    assert all(v.cycles == len(record.outputs) and 0.0 < v.worst < 1e-3 for v in spoilt)
    assert all(v.verdict == IDENTICAL for v in judged if v not in spoilt)
    complete(found)
    assert spoilt
