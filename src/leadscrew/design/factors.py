"""Step 6 of a design: the contraction-expansion factors, and which law they go into.

``vud_beta_e``
    the output's factor follows the error, ``output_gain (|e|^output_tau + floor)``: the law of (21) with (19) changed;
``vud``
    as printed: the output's factor follows the last duty, (19), and the axis creeps. For a constant ``shape`` the duty
    falls to ``shape^(1 / (1 - tau))``.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from leadscrew.kernel.errors import ValueRefused

Law = Literal["vud_beta_e", "vud"]
LAWS: tuple[Law, ...] = ("vud_beta_e", "vud")


@dataclass(frozen=True)
class Factors:
    """Exponents and floor of (17) to (19), and the law."""

    law: Law = "vud_beta_e"
    tau: float = 0.9
    floor: float = 1e-4
    output_tau: float = 0.6
    output_gain: float = 1.5

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ValueRefused(f"law = {self.law!r}: allowed are {', '.join(LAWS)}")
        for name, low, high in (("tau", 0.0, 2.0), ("output_tau", 0.0, 2.0)):
            if not low <= getattr(self, name) <= high:
                raise ValueRefused(f"{name} = {getattr(self, name)!r}: allowed are {low:g} to {high:g}")
        if not 0.0 < self.floor <= 1.0:
            raise ValueRefused(f"floor = {self.floor!r}: allowed is above 0 to 1")
        if not 0.0 < self.output_gain < float("inf"):
            raise ValueRefused(f"output_gain = {self.output_gain!r}: must be above 0")

    def parameters(self) -> dict[str, float]:
        """Of the controller's block."""
        found = {"tau": self.tau, "floor": self.floor}
        if self.law == "vud_beta_e":
            found |= {"output_tau": self.output_tau, "output_gain": self.output_gain}
        return found

    def lines(self) -> list[str]:
        """The step as text."""
        inputs = f"alpha(x) = |x|^{self.tau:g} + {self.floor:g} for x = e and ec, 1 in the first period (17), (18)"
        if self.law == "vud":
            power = f", a power of {1.0 / (1.0 - self.tau):.3g}," if self.tau < 1.0 else ""
            return [
                inputs,
                f"beta = |duty|^{self.tau:g} + {self.floor:g} as printed (19), as asked: the duty is made from the "
                f"last one{power} and the axis creeps",
            ]
        return [
            inputs,
            f"beta = {self.output_gain:g} (|e|^{self.output_tau:g} + {self.floor:g}) in place of (19): the printed "
            "factor follows the last duty and makes the axis creep (--law vud writes it all the same)",
        ]

    def as_dict(self) -> dict[str, Any]:
        """The same as plain data."""
        return asdict(self)
