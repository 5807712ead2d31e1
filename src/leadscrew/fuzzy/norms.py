"""T-norms, S-norms and hedges by number: plain steps, so they run on every engine.

T-norms (a and b): minimum; a b; max(0, a + b - 1); drastic (the smaller where the other is 1, else 0);
Einstein a b / (2 - (a + b - a b)); Hamacher a b / (a + b - a b); nilpotent (the smaller where a + b > 1, else 0).

S-norms: maximum; a + b - a b; min(1, a + b); drastic (the larger where the other is 0, else 1); Einstein
(a + b)/(1 + a b); Hamacher (a + b - 2 a b)/(1 - a b); nilpotent (the larger where a + b < 1, else 1); normalized
(a + b)/max(1, a + b); unbounded a + b.

Hedges: any 1; not 1 - x; very x^2; somewhat sqrt(x); extremely 2 x^2 up to 1/2, 1 - 2 (1 - x)^2 above; seldom
sqrt(x/2) up to 1/2, 1 - sqrt((1 - x)/2) above.
"""

from __future__ import annotations

from leadscrew.fuzzy.system import HEDGES, S_NORMS, T_NORMS
from leadscrew.kernel.portable import sqrt

T_CODES = {name: code for code, name in enumerate(T_NORMS)}
S_CODES = {name: code for code, name in enumerate(S_NORMS)}
HEDGE_CODES = {name: code for code, name in enumerate(HEDGES)}
ANY, EXTREMELY, NOT, SELDOM, SOMEWHAT, VERY = range(6)
MINIMUM, PRODUCT, T_BOUNDED, T_DRASTIC, T_EINSTEIN, T_HAMACHER, T_NILPOTENT = range(7)
MAXIMUM, SUM, S_BOUNDED, S_DRASTIC, S_EINSTEIN, S_HAMACHER, S_NILPOTENT, S_NORMALIZED, S_UNBOUNDED = range(9)


def t_norm(code, a, b):
    """The conjunction of two memberships."""
    both = min(a, b)
    if code == PRODUCT:
        both = a * b
    elif code == T_BOUNDED:
        both = max(0.0, a + b - 1.0)
    elif code == T_DRASTIC:
        both = min(a, b) if max(a, b) == 1.0 else 0.0
    elif code == T_EINSTEIN:
        both = a * b / (2.0 - (a + b - a * b))
    elif code == T_HAMACHER:
        under = a + b - a * b
        both = a * b / under if under != 0.0 else 0.0
    elif code == T_NILPOTENT:
        both = min(a, b) if a + b > 1.0 else 0.0
    return both


def s_norm(code, a, b):
    """The disjunction of two memberships."""
    either = max(a, b)
    if code == SUM:
        either = a + b - a * b
    elif code == S_BOUNDED:
        either = min(1.0, a + b)
    elif code == S_DRASTIC:
        either = max(a, b) if min(a, b) == 0.0 else 1.0
    elif code == S_EINSTEIN:
        either = (a + b) / (1.0 + a * b)
    elif code == S_HAMACHER:
        under = 1.0 - a * b
        either = (a + b - 2.0 * a * b) / under if under != 0.0 else 1.0
    elif code == S_NILPOTENT:
        either = max(a, b) if a + b < 1.0 else 1.0
    elif code == S_NORMALIZED:
        either = (a + b) / max(1.0, a + b)
    elif code == S_UNBOUNDED:
        either = a + b
    return either


def hedged(code, x):
    """A membership under a hedge."""
    made = x
    if code == ANY:
        made = 1.0
    elif code == EXTREMELY:
        made = 2.0 * x * x if x <= 0.5 else 1.0 - 2.0 * (1.0 - x) * (1.0 - x)
    elif code == NOT:
        made = 1.0 - x
    elif code == SELDOM:
        made = sqrt(0.5 * x) if x <= 0.5 else 1.0 - sqrt(0.5 * (1.0 - x))
    elif code == SOMEWHAT:
        made = sqrt(x)
    elif code == VERY:
        made = x * x
    return made
