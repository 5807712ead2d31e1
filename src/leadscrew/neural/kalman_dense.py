"""The Kalman update of a linear network by plain matrix formulas: what the fast one is held against.

    s = h' P h + R      K = P h / s      w += K inn

    naive        P = P - K (P h)'
    symmetrised  P = (P + P') / 2 after P = P - K (h' P)
    joseph       P = (I - K h') P (I - K h')' + R K K'

and ``P / forgetting`` before each update where ``forgetting`` is below one. In exact arithmetic all forms agree. The
naive one takes the same product from both triangles, so an error of ``P h`` never shows as asymmetry and is never taken
back: in single precision its covariance is soon not positive definite any more. In double precision it is; it is the
form of :func:`leadscrew.neural.kalman.kalman_learn`.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from leadscrew.neural.inference_net import Fired
from leadscrew.util.errors import NameUnknown

Form = Literal["naive", "symmetrised", "joseph"]
FORMS: tuple[Form, ...] = ("naive", "symmetrised", "joseph")


def regressor(fired: Fired) -> np.ndarray:
    """All 49 firing strengths, four of them above zero."""
    mu, nu = np.zeros(7), np.zeros(7)
    mu[fired.i : fired.i + 2] = 1.0 - fired.mu, fired.mu
    nu[fired.j : fired.j + 2] = 1.0 - fired.nu, fired.nu
    return np.kron(nu, mu)


def updated(p: Any, h: Any, r: float, form: Form = "symmetrised", forgetting: float = 1.0) -> tuple[Any, Any]:
    """The gain ``K`` and the covariance after one sample, in the precision of ``p``.

    Raises:
        NameUnknown: an unknown form.
    """
    if form not in FORMS:
        raise NameUnknown(f"form = {form!r}: there are {', '.join(FORMS)}")
    kind = p.dtype.type
    p = p if forgetting == 1.0 else p / kind(forgetting)
    h = h.astype(p.dtype)
    ph = p @ h
    gain = ph / (h @ ph + kind(r))
    if form == "joseph":
        left = np.eye(len(h), dtype=p.dtype) - np.outer(gain, h)
        return gain, left @ p @ left.T + kind(r) * np.outer(gain, gain)
    if form == "naive":
        return gain, p - np.outer(gain, ph)
    after = p - np.outer(gain, h @ p)
    return gain, kind(0.5) * (after + after.T)


def kalman_learn_dense(
    weights: np.ndarray,
    covariance: np.ndarray,
    fired: Fired,
    innovation: float,
    r: float,
    q: float,
    cap: float,
    clamp: float,
) -> float:
    """What :func:`leadscrew.neural.kalman.kalman_learn` does, in place, without use of what is known to be zero."""
    h = regressor(fired)
    s = float(h @ covariance @ h + r)
    gain, after = updated(covariance, h, r, "symmetrised")
    after = after + q * np.eye(len(h))
    for i in range(len(h)):
        if after[i, i] > cap:
            factor = np.sqrt(cap / after[i, i])
            after[i, :] *= factor
            after[:, i] *= factor
    weights[:] = np.clip(weights + gain * innovation, -clamp, clamp)
    covariance[:] = after
    return s
