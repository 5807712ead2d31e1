"""What ``identify linear`` found: a transfer function with delay, intervals, and its errors on validation data."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from leadscrew.identify.estimation import Parameter
from leadscrew.identify.linear.model import Structure
from leadscrew.identify.linear.uncertainty import Bode
from leadscrew.util.errors import DataError

if TYPE_CHECKING:
    from leadscrew.analysis.frequency_response import FrequencyResponse
    from leadscrew.kernel.block import Block
    from leadscrew.machine.file import MachineFile


__all__ = ["Candidate", "LinearFit", "Parameter", "Stretch", "Structure"]


class Candidate(NamedTuple):
    """One structure that was tried."""

    structure: Structure
    delay_s: float
    train_rms: float
    holdout_rms: float
    """NaN where nothing was held out."""
    against: str
    """``chosen``, or what speaks against it."""


class Stretch(NamedTuple):
    """Measured against simulated, over one part of the log."""

    what: str
    """``training`` or ``hold-out``."""
    start_s: float
    end_s: float
    rms: float
    """Of measured less simulated, in the output's unit."""
    worst: float
    nrmse_percent: float
    """``rms`` over the range of the measured output."""
    fit_percent: float
    """``100 (1 - rms / standard deviation of the output)``, as MATLAB's ``compare`` counts."""
    time: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray


@dataclass(frozen=True)
class LinearFit:
    """``numerator(s) / denominator(s) * exp(-delay_s s)`` from input to output, in their own units."""

    source: str
    structure: Structure
    numerator: np.ndarray
    """Highest power of ``s`` first."""
    denominator: np.ndarray
    """Highest power first, monic; the poles at zero are its zeros at the end."""
    delay_s: float
    """From the sample of an input to the moment at which it acts."""
    offset: Parameter
    """Added to the output; with poles at zero, taken from the input."""
    input_name: str
    output_name: str
    input_unit: str
    output_unit: str
    period: float
    coefficients: dict[str, Parameter]
    """``b0``, ``b1`` of the numerator and ``a0``, ``a1``, ... of the denominator, by power of ``s``."""
    parameters: dict[str, Parameter]
    """``gain``, ``pole 1`` (1/s), ``frequency 1`` (Hz) and ``damping 1`` of pairs, ``zero 1``, ``delay_s``."""
    covariance: np.ndarray
    """Of ``b0 ..., a0 ..., delay_s``, in the order of ``coefficients``."""
    condition: float
    stretches: list[Stretch]
    candidates: list[Candidate]
    margin: float
    method: str
    closed_loop: bool
    """Whether the command was the instrument."""
    whiteness: float
    """Share in percent of the training residual's autocorrelations within 95 % bounds: about 95 for white noise."""
    autocorrelation: np.ndarray
    """Of the training residual, from lag 1."""
    missed: float
    """Largest correlation of the residual with the whitened input before it, in standard deviations; above 4 the model
    misses something that the input does."""
    feedback: float
    """The same with the input after it: above 4 the input answers the output, which is a closed loop."""
    excited_hz: tuple[float, float]
    """Where the input moves the output by more than what is left; from the first to the last frequency."""
    bode: Bode
    limits: dict[str, Any]
    """What the log has shown: largest ``drive``, ``speed`` and ``acceleration`` of the simulated output, ``travel``."""
    measured: FrequencyResponse | None
    """The log's own frequency response, without a model; ``None`` where the log is too short for one."""
    resolution: float = 0.0
    """Grid of the measured output, in its unit; 0 for none."""
    noise: float = 0.0
    """Of the measured output besides its rounding, root mean square, in its unit."""
    notes: list[str] = field(default_factory=list)
    advice: list[str] = field(default_factory=list)

    @property
    def unit(self) -> str:
        """Of the gain without the poles at zero."""
        per = f" s^{self.structure.integrators}" if self.structure.integrators > 1 else " s"
        below = f"({self.input_unit}{per})" if self.structure.integrators else self.input_unit
        return f"{self.output_unit}/{below}"

    @property
    def poles(self) -> np.ndarray:
        """1/s, those at zero included."""
        return np.roots(self.denominator)

    @property
    def zeros(self) -> np.ndarray:
        """1/s."""
        return np.roots(self.numerator)

    def stretch(self, what: str) -> Stretch | None:
        """The part of that name."""
        return next((s for s in self.stretches if s.what == what), None)

    def response(self, frequencies_hz: Any) -> np.ndarray:
        """Complex response of the continuous model, delay included and without a hold."""
        s = 2j * np.pi * np.asarray(frequencies_hz, dtype=float)
        found = np.polyval(self.numerator, s) / np.polyval(self.denominator, s) * np.exp(-s * self.delay_s)
        return np.asarray(found)

    def as_dict(self) -> dict[str, Any]:
        """The fit for JSON, without its signals."""
        return {
            "source": self.source, "structure": self.structure._asdict(), "numerator": self.numerator.tolist(),
            "denominator": self.denominator.tolist(), "delay_s": self.delay_s, "offset": self.offset._asdict(),
            "input": {"column": self.input_name, "unit": self.input_unit},
            "output": {"column": self.output_name, "unit": self.output_unit}, "gain_unit": self.unit,
            "period_s": self.period, "coefficients": {k: v._asdict() for k, v in self.coefficients.items()},
            "parameters": {k: v._asdict() for k, v in self.parameters.items()},
            "covariance": self.covariance.tolist(), "condition": self.condition,
            "stretches": [{n: getattr(s, n) for n in Stretch._fields[:7]} for s in self.stretches],
            "candidates": [{**c._asdict(), "structure": c.structure._asdict()} for c in self.candidates],
            "margin": self.margin, "method": self.method, "closed_loop": self.closed_loop,
            "whiteness_percent": self.whiteness, "missed": self.missed, "feedback": self.feedback,
            "excited_hz": list(self.excited_hz), "limits": self.limits, "resolution": self.resolution,
            "noise": self.noise, "notes": self.notes, "advice": self.advice,
        }  # fmt: skip


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
    made = from_linear(machine_values(fit), name, limits(fit), fit.source)
    errors = {
        s.what.replace("-", "_"): {"rms": s.rms, "nrmse_percent": s.nrmse_percent, "fit_percent": s.fit_percent}
        for s in fit.stretches
    }
    unknown = [name for name, p in fit.parameters.items() if not p.identifiable]
    more = {
        **errors,
        "not_identifiable": unknown,
        "notes": list(fit.notes),
        "seconds": max(s.end_s for s in fit.stretches),
    } | ({"drive_turned": True} if turns(fit) else {})
    return replace(made, identified={**made.identified, "structure": fit.structure.text, **more})


def block(fit: LinearFit, name: str = "linear") -> Block:
    """The plant without its delay: give the loop ``computation_delay=fit.delay_s``."""
    from leadscrew.plants._linear import transfer_function

    return transfer_function(fit.numerator, fit.denominator, name)
