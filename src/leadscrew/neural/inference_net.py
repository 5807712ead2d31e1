"""The fuzzy inference network: 2 inputs, 14 memberships, 49 product rules, normalisation, 1 output.

    a_k = mu_i(E) nu_j(EC)        D = sum a_k w_k / sum a_k,    k = 7 j + i,  i, j = 0..6 for NB..PB

``E`` and ``EC`` are the levels (-6..6) of the error and of its change, ``D`` the level of the offset angle, ``w`` the
49 consequents in levels (``v_ok`` of the paper). The memberships (``v_ji``) are triangles that cross at 1/2, shouldered
at the ends; they sum to one, so the denominator is one, four rules fire at most, and the output is the bilinear
interpolation of the consequents.

Equation (2) of the paper of the study sofnn_tangent, Y. Deng, X. Liu, L. Wu, Q. Zhang. The paper shows neither the
memberships (its figure 3 is missing) nor the rules: centres and rules here are a reconstruction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from leadscrew.fuzzy.inference import axis, inside_universe, interval_index, upper_membership

LABELS = ("NB", "NM", "NS", "ZO", "PS", "PM", "PB")
"""Names of the seven sets of each input, from large negative to large positive."""
CENTRES = np.array([-6.0, -4.0, -2.0, 0.0, 2.0, 4.0, 6.0])
"""Peaks of the seven sets of each input, in levels."""
AXIS = axis(CENTRES)
"""The partition with these centres, as a step reads it."""
SETS = 7
RULES = SETS * SETS
CLAMP = 6.0
"""Consequents lie between -6 and 6 levels."""

CHINESE_RULES = np.array(
    [
        [6.0, 6.0, 4.0, 4.0, 2.0, 0.0, 0.0],
        [6.0, 6.0, 4.0, 2.0, 2.0, 0.0, -2.0],
        [4.0, 4.0, 4.0, 2.0, 0.0, -2.0, -2.0],
        [4.0, 4.0, 2.0, 0.0, -2.0, -4.0, -4.0],
        [2.0, 2.0, 0.0, -2.0, -2.0, -4.0, -4.0],
        [2.0, 0.0, -2.0, -4.0, -4.0, -4.0, -6.0],
        [0.0, 0.0, -4.0, -4.0, -4.0, -6.0, -6.0],
    ]
)
"""The 49 rules common in Chinese texts (levels, rows EC from NB, columns E from NB), with the sign for
e = actual - reference: the alternative to :func:`initial_rules`."""

W0 = np.array(
    [
        [5.290580, 5.275252, 5.291595, 5.013288, 3.868380, 2.022154, 0.0],
        [5.275252, 5.279433, 4.999159, 3.716327, 2.012408, 0.0, -2.022154],
        [5.291595, 4.999159, 3.718932, 2.038709, 0.0, -2.012408, -3.868380],
        [5.013288, 3.716327, 2.038709, 0.0, -2.038709, -3.716327, -5.013288],
        [3.868380, 2.012408, 0.0, -2.038709, -3.718932, -4.999159, -5.291595],
        [2.022154, 0.0, -2.012408, -3.716327, -4.999159, -5.279433, -5.275252],
        [0.0, -2.022154, -3.868380, -5.013288, -5.291595, -5.275252, -5.290580],
    ]
).ravel()
"""The 49 consequents (levels, number 7 EC + E) after one Kalman pass over 169 fuzzy reasoning samples: what the network
starts from. :func:`leadscrew.neural.samples.trained_start` makes them again."""


class Fired(NamedTuple):
    """Which four rules fire, and how much: rules ``7 j + i`` and its right, upper and upper right neighbour."""

    i: int = 0
    """Lower of the two sets of E that fire."""
    j: int = 0
    """Lower of the two sets of EC."""
    mu: float = 0.0
    """Membership of E in set i + 1; set i has the rest to one."""
    nu: float = 0.0
    """Membership of EC in set j + 1."""


def initial_rules() -> np.ndarray:
    """The 7 x 7 rules before training (levels, rows EC from NB, columns E from NB): ``2 clip(-(i + j), -3, 3)``.

    The sign pattern of MacVicar-Whelan for e = actual - reference and a plant of positive gain. A reconstruction: the
    paper gives no rule.
    """
    step = np.arange(-3, 4)
    return np.asarray(2.0 * np.clip(-(step[:, None] + step[None, :]), -3, 3) + 0.0)


def fired(axis_e, axis_ec, e, ec):
    """The rules that fire at the levels ``(e, ec)``, each held inside its universe; for a step."""
    e_inside = inside_universe(axis_e, e)
    ec_inside = inside_universe(axis_ec, ec)
    i = interval_index(axis_e, e_inside)
    j = interval_index(axis_ec, ec_inside)
    return Fired(i, j, upper_membership(axis_e, i, e_inside), upper_membership(axis_ec, j, ec_inside))


class Strengths(NamedTuple):
    """Firing strengths of the four rules: ``7 j + i``, its right, its upper and its upper right neighbour."""

    h0: float
    h1: float
    h2: float
    h3: float


def strengths(fired):
    """How much each of the four rules fires; for a step."""
    return Strengths(
        (1.0 - fired.nu) * (1.0 - fired.mu), (1.0 - fired.nu) * fired.mu, fired.nu * (1.0 - fired.mu),
        fired.nu * fired.mu,
    )  # fmt: skip


def network_output(weights, fired):
    """Output of the network in levels: the four consequents that fire, weighted; for a step. Not limited."""
    k = 7 * fired.j + fired.i
    lower = (1.0 - fired.mu) * weights[k] + fired.mu * weights[k + 1]
    upper = (1.0 - fired.mu) * weights[k + 7] + fired.mu * weights[k + 8]
    return (1.0 - fired.nu) * lower + fired.nu * upper


def regressors(e, ec, centres_e=CENTRES, centres_ec=CENTRES) -> np.ndarray:
    """The row ``h`` with ``D = h . w`` of each point, ``[point, 49]``: firing strengths of all rules, for design."""
    peaks = np.eye(SETS)
    mu = np.stack([np.interp(np.ravel(e), centres_e, peak) for peak in peaks], axis=-1)
    nu = np.stack([np.interp(np.ravel(ec), centres_ec, peak) for peak in peaks], axis=-1)
    return np.asarray((nu[:, :, None] * mu[:, None, :]).reshape(len(mu), RULES))
