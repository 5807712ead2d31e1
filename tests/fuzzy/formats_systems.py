"""Random fuzzy systems, limited to what a format can say, and the files that tests share."""

import math
import re
from pathlib import Path

from hypothesis import strategies as st

from leadscrew.fuzzy.formats.fcl import KEYWORDS
from leadscrew.fuzzy.rules_text import RESERVED
from leadscrew.fuzzy.system import (
    INTEGRAL,
    RULES_OF_SUM,
    S_NORMS,
    SHAPES,
    T_NORMS,
    And,
    Input,
    Is,
    Or,
    Output,
    Rule,
    RuleBlock,
    System,
    Term,
)
from tests.tools import missing

SHARED = Path(__file__).parents[3] / "shared"
MONOTONE = ("ramp", "sigmoid", "s_shape", "z_shape", "concave")
FIS_SHAPES = tuple(s for s in SHAPES if s not in ("singleton", "constant", "linear"))
POINT_SHAPES = ((0.0, 1.0), (1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 1.0, 1.0, 0.0))
ACTIVATED = (
    ("general", ()),
    ("first", ("2", "0.1")),
    ("highest", ("3",)),
    ("proportional", ()),
    ("threshold", (">", "0.25")),
)
HEDGES_OF_FIS = ((), ("somewhat",), ("very",), ("extremely",), ("very", "very"))


def shared(path: str) -> Path:
    """A file beside the repository; the test skips where it is not there."""
    found = SHARED / path
    if not found.exists():
        missing("shared", f"{found} is not on this machine")
    return found


def words(pattern: str):
    return st.from_regex(pattern, fullmatch=True).filter(
        lambda w: w.casefold() not in RESERVED and w.casefold() not in (*KEYWORDS, "inf", "nan")
    )


NAMES = {
    "fis": st.text(
        st.characters(codec="utf-8", categories=("L", "N", "P", "S", "Zs"), exclude_characters="'"), min_size=1
    )
    .map(lambda s: " ".join(s.split()))
    .filter(lambda s: s and s.isprintable()),
    "fll": words(r"[A-Za-z0-9_.]{1,8}"),
    "fcl": words(r"[A-Za-z_][A-Za-z0-9_]{0,7}"),
}  # fmt: skip
TITLES = {
    "fis": NAMES["fis"],
    "fll": st.lists(st.from_regex(r"[A-Za-z0-9:;'\"()é-]{1,6}", fullmatch=True), max_size=3).map(" ".join),
    "fcl": st.lists(words(r"[A-Za-z_][A-Za-z0-9_]{0,7}"), max_size=3).map(" ".join),
}
NUMBERS = st.one_of(
    st.integers(-100_000, 100_000).map(lambda k: k / 1000.0),
    st.floats(allow_nan=False, allow_infinity=False, width=64),
)
SHORT = st.integers(-100_000, 100_000).map(lambda k: k / 1000.0)
"""Numbers that fuzzylite writes in full with 17 digits after the point."""


@st.composite
def universes(draw, numbers):
    low, high = draw(numbers), draw(numbers)
    if low == high:
        high = low + 1.0 if abs(low) < 1e15 else math.inf
    return min(low, high), max(low, high)


@st.composite
def terms(draw, name, shapes, numbers, height, inputs):
    shape = draw(st.sampled_from(shapes))
    tall = 1.0 if shape in ("constant", "linear", "singleton") else draw(height)
    if shape == "discrete":
        xs = sorted(draw(st.lists(numbers, min_size=2, max_size=5)))
        ys = draw(st.lists(numbers, min_size=len(xs), max_size=len(xs)).filter(lambda y: tuple(y) not in POINT_SHAPES))
        return Term(name, shape, tuple(v for pair in zip(xs, ys, strict=True) for v in pair), tall)
    count = inputs + 1 if shape == "linear" else len(SHAPES[shape])
    values = draw(st.lists(numbers, min_size=count, max_size=count))
    if shape == "triangle" and draw(st.booleans()):
        values[0] = -math.inf
    return Term(name, shape, tuple(values), tall)


@st.composite
def antecedents(draw, variables, depth=3):
    if depth and draw(st.booleans()):
        kind = draw(st.sampled_from((And, Or)))
        return kind(draw(antecedents(variables, depth - 1)), draw(antecedents(variables, depth - 1)))
    variable = draw(st.sampled_from(variables))
    hedges = tuple(draw(st.lists(st.sampled_from(("extremely", "not", "seldom", "somewhat", "very")), max_size=2)))
    if draw(st.integers(0, 5)) == 0:
        return Is(variable.name, "", (*hedges, "any"))
    return Is(variable.name, draw(st.sampled_from(variable.terms)).name, hedges)


@st.composite
def systems(draw, format, numbers=NUMBERS, every_rule_of_sum=True, lock_input=True):
    """A random system that a format can say in full."""
    counts = draw(st.integers(1, 3)), draw(st.integers(1, 2))
    names = draw(st.lists(NAMES[format], min_size=sum(counts), max_size=sum(counts), unique=True))
    height = st.just(1.0) if format == "fis" else st.sampled_from((1.0, 0.5, 0.25))
    flag = st.just(False) if format == "fis" else st.booleans()
    weighted = draw(st.booleans())
    doc = TITLES["fll"] if format == "fll" else st.just("")

    def of(shapes):
        known = draw(st.lists(NAMES[format], min_size=1, max_size=3, unique=True))
        return tuple(draw(terms(name, shapes, numbers, height, counts[0])) for name in known)

    inputs = []
    for name in names[: counts[0]]:
        shapes = (*FIS_SHAPES, *(("singleton",) if format == "fcl" else ()))
        low, high = draw(universes(numbers))
        lock = draw(flag) if format == "fll" and lock_input else False
        inputs.append(Input(name, low, high, of(shapes), doc=draw(doc), enabled=not draw(flag), lock_range=lock))
    outputs = []
    kind = (draw(st.sampled_from(S_NORMS)), draw(st.sampled_from(INTEGRAL)))
    for name in names[counts[0] :]:
        weighted = weighted if format == "fis" else draw(st.booleans())
        low, high = draw(universes(numbers))
        aggregation, defuzzifier = (
            kind if format == "fis" else (draw(st.sampled_from(S_NORMS)), draw(st.sampled_from(INTEGRAL)))
        )
        integration, resolution = ("trapezoid" if format == "fis" else "midpoint"), 100
        if every_rule_of_sum:
            integration, resolution = draw(st.sampled_from(RULES_OF_SUM)), draw(st.integers(1, 1000))
        elif format == "fll":
            resolution = draw(st.integers(1, 1000))
        if weighted:
            aggregation = None if format == "fis" else draw(st.sampled_from((None, *S_NORMS)))
            defuzzifier = (
                "weighted_average" if format == "fis" else draw(st.sampled_from(("weighted_average", "weighted_sum")))
            )
            integration, resolution = "midpoint", 100
        shapes = draw(st.sampled_from((("constant", "linear"), MONOTONE))) if weighted else FIS_SHAPES
        if format == "fcl" and not weighted:
            shapes = (*shapes, "singleton")
        outputs.append(
            Output(
                name, low, high, of(shapes), doc=draw(doc), enabled=not draw(flag), lock_range=draw(flag),
                aggregation=aggregation, defuzzifier=defuzzifier, integration=integration, resolution=resolution,
                default=math.nan if format == "fis" else draw(st.one_of(st.just(math.nan), numbers)),
                lock_previous=draw(flag),
            )
        )  # fmt: skip
    blocks = tuple(
        draw(rule_blocks(format, inputs, outputs, weighted))
        for _ in range(1 if format == "fis" else draw(st.integers(0, 2)))
    )
    title = draw(TITLES[format])
    return System(title, tuple(inputs), tuple(outputs), blocks, doc=draw(doc))


@st.composite
def rule_blocks(draw, format, inputs, outputs, weighted):
    rules = [
        draw(flat_rules(inputs, outputs) if format == "fis" else tree_rules(inputs, outputs))
        for _ in range(draw(st.integers(0, 3)))
    ]
    norms = {"conjunction": T_NORMS, "disjunction": S_NORMS, "implication": T_NORMS}
    found = {key: draw(st.sampled_from((None, *known) if format == "fll" else known)) for key, known in norms.items()}
    if format == "fis":
        return RuleBlock(tuple(rules), **(found | ({"implication": None} if weighted else {})))
    title = draw(TITLES[format])
    activation, parameters = "general", ()
    if format == "fll":
        activation, parameters = draw(
            st.sampled_from(ACTIVATED)
        )  # fmt: skip
    return RuleBlock(
        tuple(rules), title if format == "fll" else title.replace(" ", ""), **found,
        activation=activation, activation_parameters=parameters,
        enabled=draw(st.booleans()),
    )  # fmt: skip


WEIGHTS = st.one_of(st.just(1.0), st.integers(0, 1000).map(lambda k: k / 1000.0))


@st.composite
def tree_rules(draw, inputs, outputs):
    hedges = st.lists(st.sampled_from(("not", "very")), max_size=1)
    then = [
        Is(o.name, draw(st.sampled_from(o.terms)).name, tuple(draw(hedges)))
        for o in draw(st.lists(st.sampled_from(outputs), min_size=1, max_size=2))
    ]
    return Rule(draw(antecedents([*inputs, *outputs])), tuple(then), draw(WEIGHTS))


@st.composite
def flat_rules(draw, inputs, outputs):
    kind = draw(st.sampled_from((And, Or)))
    sides = []
    for variables in (inputs, outputs):
        chosen = draw(st.lists(st.sampled_from(range(len(variables))), min_size=1, unique=True).map(sorted))
        clauses = []
        for k in chosen:
            hedges = (*draw(st.sampled_from(((), ("not",)))), *draw(st.sampled_from(HEDGES_OF_FIS)))
            clauses.append(Is(variables[k].name, draw(st.sampled_from(variables[k].terms)).name, hedges))
        sides.append(clauses)
    node = sides[0][0]
    for there in sides[0][1:]:
        node = kind(node, there)
    return Rule(node, tuple(sides[1]), draw(WEIGHTS))


def plain_comments(text: str) -> str:
    """A text without the comments that keep rules of integration."""
    return re.sub(r"(?m)^(?:#|%|//) leadscrew:.*\n", "", text)
