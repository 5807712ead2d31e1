"""What each format calls the norms, shapes and defuzzifiers of :mod:`leadscrew.fuzzy.system`."""

from __future__ import annotations

from leadscrew.fuzzy.formats.place import plain
from leadscrew.fuzzy.system import ACTIVATIONS, DEFUZZIFIERS, S_NORMS, SHAPES, T_NORMS, Term
from leadscrew.kernel.parameters import nearest
from leadscrew.util.errors import ValueRefused


def class_name(name: str) -> str:
    """``smallest_of_maximum`` as fuzzylite writes it: ``SmallestOfMaximum``."""
    return "".join(part.capitalize() for part in name.split("_"))


FLL_SHAPES = {class_name(name): name for name in SHAPES if name != "singleton"}
FLL_NORMS = {class_name(name): name for name in (*T_NORMS, *S_NORMS)}
FLL_DEFUZZIFIERS = {class_name(name): name for name in DEFUZZIFIERS if name != "height"}
FLL_ACTIVATIONS = {class_name(name): name for name in ACTIVATIONS}
NO_SHAPE = {
    "Function": "a formula, and formulas of files are not evaluated",
    "Arc": "a shape that Leadscrew does not have",
    "SemiEllipse": "a shape that Leadscrew does not have",
}
"""Shapes of fuzzylite that are refused, and what they are."""

FCL_T_NORMS = {
    "MIN": "minimum",
    "PROD": "algebraic_product",
    "BDIF": "bounded_difference",
    "DPROD": "drastic_product",
    "EPROD": "einstein_product",
    "HPROD": "hamacher_product",
    "NMIN": "nilpotent_minimum",
    "DMIN": "drastic_product",
    "HAMACHER": "hamacher_product",
    "NIPMIN": "nilpotent_minimum",
}
"""The first name of each norm is the one that is written (fuzzylite's); the later ones are jFuzzyLogic's."""
FCL_S_NORMS = {
    "MAX": "maximum",
    "ASUM": "algebraic_sum",
    "BSUM": "bounded_sum",
    "DSUM": "drastic_sum",
    "ESUM": "einstein_sum",
    "HSUM": "hamacher_sum",
    "NMAX": "nilpotent_maximum",
    "NSUM": "normalized_sum",
    "UnboundedSum": "unbounded_sum",
    "SUM": "unbounded_sum",
    "PROBOR": "algebraic_sum",
    "DMAX": "drastic_sum",
    "EINSTEIN": "einstein_sum",
    "NIPMAX": "nilpotent_maximum",
}
FCL_METHODS = {
    "COG": "centroid",
    "COA": "bisector",
    "LM": "smallest_of_maximum",
    "MM": "mean_of_maximum",
    "RM": "largest_of_maximum",
    "COGS": "weighted_average",
    "COGSS": "weighted_sum",
    "COGF": "weighted_average",
}
DUALS = dict(zip(T_NORMS, S_NORMS, strict=False))
"""The S-norm that De Morgan's law pairs with each T-norm (IEC 61131-7 wants them used in pairs)."""

FIS_T_NORMS = {
    "min": "minimum",
    "prod": "algebraic_product",
    **{name: name for name in T_NORMS[2:]},
    "algebraic_product": "algebraic_product",
}
FIS_S_NORMS = {
    "max": "maximum",
    "probor": "algebraic_sum",
    "sum": "unbounded_sum",
    **{name: name for name in S_NORMS[2:] if name != "unbounded_sum"},
    "algebraic_sum": "algebraic_sum",
}
FIS_DEFUZZIFIERS = {
    "centroid": "centroid",
    "bisector": "bisector",
    "mom": "mean_of_maximum",
    "lom": "largest_of_maximum",
    "som": "smallest_of_maximum",
    "wtaver": "weighted_average",
    "wtsum": "weighted_sum",
}
FIS_SHAPES: dict[str, tuple[str, tuple[int, ...]]] = {
    "trimf": ("triangle", (0, 1, 2)),
    "trapmf": ("trapezoid", (0, 1, 2, 3)),
    "gaussmf": ("gaussian", (1, 0)),
    "gauss2mf": ("gaussian_product", (1, 0, 3, 2)),
    "gbellmf": ("bell", (2, 0, 1)),
    "sigmf": ("sigmoid", (1, 0)),
    "dsigmf": ("sigmoid_difference", (1, 0, 2, 3)),
    "psigmf": ("sigmoid_product", (1, 0, 2, 3)),
    "pimf": ("pi_shape", (0, 1, 2, 3)),
    "smf": ("s_shape", (0, 1)),
    "zmf": ("z_shape", (0, 1)),
    "linsmf": ("ramp", (0, 1)),
    "linzmf": ("ramp", (1, 0)),
    "constant": ("constant", (0,)),
    "linear": ("linear", ()),
    "discretemf": ("discrete", ()),
    "binarymf": ("binary", (0, 1)),
    "concavemf": ("concave", (0, 1)),
    "cosinemf": ("cosine", (0, 1)),
    "spikemf": ("spike", (0, 1)),
    "rectmf": ("rectangle", (0, 1)),
    "rampmf": ("ramp", (0, 1)),
}
"""The shape of each kind of membership function, and which number of the file is which parameter. From ``discretemf``
on they are fuzzylite's own, which MATLAB and Octave do not read."""
FUZZYLITE_ONLY = tuple(FIS_SHAPES)[tuple(FIS_SHAPES).index("discretemf") :]


def first_name(table: dict[str, str], value: str) -> str | None:
    """The name under which a table knows a value."""
    return next((name for name, known in table.items() if known == value), None)


def class_term(name: str, kind: str, numbers: list[float]) -> Term:
    """A term as fuzzylite writes it: class and numbers, the last one of which may be the height.

    Raises:
        ValueRefused: there is no such class, or the numbers do not fit.
    """
    if kind in NO_SHAPE:
        raise ValueRefused(f"term {name}: a {kind} is {NO_SHAPE[kind]}")
    if kind not in FLL_SHAPES:
        raise ValueRefused(f"term {name}: there is no {kind!r}{nearest(kind, list(FLL_SHAPES))}")
    shape = FLL_SHAPES[kind]
    if shape in ("constant", "linear"):
        return Term(name, shape, tuple(numbers))
    wanted = len(numbers) // 2 * 2 if shape == "discrete" else len(SHAPES[shape])
    if len(numbers) == wanted + 1:
        return Term(name, shape, tuple(numbers[:-1]), numbers[-1])
    return Term(name, shape, tuple(numbers))


def class_text(term: Term) -> str:
    """A term's class and numbers as fuzzylite writes them."""
    numbers = [*term.parameters, *([] if term.height == 1.0 else [term.height])]
    return " ".join((class_name(term.shape), *map(plain, numbers)))
