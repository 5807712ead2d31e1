"""Inside a closed loop the input answers the output's noise; what the command alone made of it does not.

The controller turns noise of the output into input, so noise and input go together, and output error is biased where
the noise is not white. The refined estimate solves, instead of ``J' e = 0``,

    Z' e(theta) = 0,    e = y - y_simulated(u; theta),    Z = d y_simulated(u_r; theta) / d theta

``u_r`` is the part of the input that the command explains: least squares on means of the command over windows that
reach back ever further. It need not be exact: whatever is made of the command is free of the noise (Young, Garnier,
Gilson, *Systems and Control Letters*, 2008; Soderstrom and Stoica, *System Identification*, 1989, chapter 8).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

FINE = 16
"""Windows of one sample each; the later ones grow."""
GROWTH = 1.35
BACK = 0.25
"""Share of the record up to which the windows reach back."""
AGREES = 0.5
"""Correlation of the input and its part from the command below which the command is no instrument."""


def from_command(u: np.ndarray, command: np.ndarray) -> tuple[np.ndarray, float]:
    """The input as the command explains it, and its correlation with the input; 0 where it is no instrument."""
    r = command - command[0]
    edges = list(range(FINE + 1))
    while edges[-1] < BACK * len(u):
        edges.append(int(np.ceil(GROWTH * edges[-1])))
    summed = np.concatenate([np.zeros(edges[-1] + 1), np.cumsum(r)])
    at = np.arange(len(u)) + edges[-1] + 1
    columns = [(summed[at - a] - summed[at - b]) / (b - a) for a, b in pairwise(edges)]
    rows = np.stack([*columns, np.ones(len(u))], axis=1)
    made = rows @ np.linalg.lstsq(rows, u, rcond=1e-9)[0]
    together = float(np.corrcoef(made, u)[0, 1]) if np.ptp(made) > 0.0 else 0.0
    return (made, together) if together > AGREES else (np.zeros_like(u), 0.0)
