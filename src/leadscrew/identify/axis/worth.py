"""Whether a model is worth anything: the two cases in which it is not are said before all else."""

from __future__ import annotations

from collections.abc import Sequence

from leadscrew.identify.axis.result import Judged

HALF = 50.0
"""Percent of the force, or of the range of the position, that a model of worth does not leave."""


def faults(judged: Sequence[Judged]) -> list[str]:
    """Why the model is worthless, in sentences; judged on unseen data where there are any."""
    open_loop = {j.what: j for j in judged if "closed" not in j.what}
    j = open_loop.get("hold-out", open_loop.get("training"))
    where = "data that the fit has not seen" if "hold-out" in open_loop else "the data of the fit itself"
    if j is None:
        return ["worthless as a model: simulated from the drive alone it diverges"]
    if j.force_percent > HALF:
        return [f"worthless as a model: on {where} it leaves {j.force_percent:.0f} % of the drive's force unexplained"]
    if j.nrmse_percent > HALF:
        return [
            f"worthless for simulation over {j.end_s - j.start_s:.3g} s: on {where} the simulated position is off by "
            f"{j.nrmse_percent:.0f} % of its range"
        ]
    return []
