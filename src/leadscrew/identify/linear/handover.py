"""From a linear fit to what simulates it: the block of a plant, and the machine of a machine file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from leadscrew.identify.linear.result import LinearFit
from leadscrew.kernel.errors import DataError

if TYPE_CHECKING:
    from leadscrew.kernel.block import Block
    from leadscrew.machine.file import MachineFile


def machine_values(fit: LinearFit) -> dict[str, Any]:
    """Of a machine file: kind, coefficients from the highest power, delay and period in s, units of the log.

    ``resolution`` and ``noise`` are those of the measured output. The controllers of machines drive forwards with a
    positive output: where the log has it the other way round, the numerator is turned and ``drive_turned`` is true.
    """
    turned = turns(fit)
    return {
        "kind": "linear", "numerator": (-fit.numerator if turned else fit.numerator).tolist(),
        "denominator": fit.denominator.tolist(), "delay_s": fit.delay_s, "position_unit": fit.output_unit,
        "drive_unit": fit.input_unit, "period": fit.period, "resolution": fit.resolution, "noise": fit.noise,
        "drive_turned": turned,
    }  # fmt: skip


def turns(fit: LinearFit) -> bool:
    """Whether a positive input moves the output backwards."""
    return bool(fit.numerator[-1] < 0.0)


def limits(fit: LinearFit) -> dict[str, Any]:
    """Of a machine file: largest drive, speed and acceleration, and the travel, as the log has shown them."""
    return dict(fit.limits)


def machine(fit: LinearFit, name: str) -> MachineFile:
    """The machine of a fit.

    Raises:
        DataError: the input moves the output by less than what the model leaves, at every frequency.
    """
    from leadscrew.machine.from_fit import from_linear

    if fit.excited_hz[1] == 0.0:
        raise DataError(
            f"{fit.source}: {fit.input_name} moves {fit.output_name} by less than what the model leaves, at every "
            "frequency: there is no model of it, and so no machine; log a move that the input makes"
        )
    told = machine_values(fit)
    made = from_linear(told, name, limits(fit), fit.source)
    errors = {
        s.what.replace("-", "_"): {"rms": s.rms, "nrmse_percent": s.nrmse_percent, "fit_percent": s.fit_percent}
        for s in fit.stretches
    }
    untold = [name for name, p in fit.parameters.items() if not p.told]
    more = {**errors, "not_told": untold, "notes": list(fit.notes), "seconds": max(s.end_s for s in fit.stretches)} | (
        {"drive_turned": True} if turns(fit) else {}
    )
    return replace(made, identified={**made.identified, "structure": fit.structure.text, **more})


def block(fit: LinearFit, name: str = "linear") -> Block:
    """The plant without its delay: give the loop ``computation_delay=fit.delay_s``."""
    from leadscrew.plants._linear import transfer_function

    return transfer_function(fit.numerator, fit.denominator, name)
