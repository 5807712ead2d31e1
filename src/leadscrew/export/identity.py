"""Which controller a certificate is about: the hash of its steps, as in an export's manifest, and its parameters."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from leadscrew.kernel.loop import Loop
from leadscrew.kernel.sheet import entries


def identity_of(loop: Loop) -> dict[str, Any]:
    """The controller of a loop: block, parameters, period, hashes.

    ``source_hash`` is that of the steps from which C, HAL component and FMU are printed: the same as in the
    ``manifest.json`` of an export of this controller. It says nothing of the parameters; ``fingerprint`` is over both
    and the period.
    """
    from leadscrew import __version__
    from leadscrew.export.source import Source

    block = loop.blocks["controller"]
    assert block is not None
    prepared = None if block.params is None else loop.prepared(block, "controller")
    state = None if block.state is None else loop.start_state(block)
    source = Source(block, prepared, state, loop.signals, name="certified", period=loop.period, real="double", head="")
    source.files()
    steps = source.module.identity()
    sheet = tuple(entries(block.params))
    parameters = {e.key: e.default.tolist() if hasattr(e.default, "tolist") else e.default for e in sheet}
    numbers = {e.key: e.stored(e.default) for e in sheet if e.choice is not None}
    said = json.dumps([steps, parameters | numbers, loop.period], sort_keys=True)
    return {
        "block": block.name,
        "parameters": parameters,
        "period_s": loop.period,
        "source_hash": steps,
        "fingerprint": hashlib.sha256(said.encode()).hexdigest()[:24],
        "leadscrew": __version__,
    }
