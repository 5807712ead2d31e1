"""Random fuzzy systems from a seed: every shape, norm, hedge, activation and defuzzifier that fuzzylite has."""

import numpy as np

from leadscrew.fuzzy.system import (
    HEDGES,
    INTEGRAL,
    S_NORMS,
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

SETS = (
    "triangle", "trapezoid", "ramp", "rectangle", "binary", "gaussian", "gaussian_product", "bell", "sigmoid",
    "sigmoid_difference", "sigmoid_product", "s_shape", "z_shape", "pi_shape", "cosine", "spike", "concave", "discrete",
)  # fmt: skip
KINDS = ("mamdani", "larsen", "zero order", "first order", "tsukamoto", "inverse tsukamoto")
DUALS = ("algebraic_sum", "bounded_sum", "drastic_sum", "einstein_sum", "hamacher_sum", "maximum",
         "nilpotent_maximum")  # fmt: skip


def term(rng, name: str, shape: str, low: float, high: float, height: bool = True) -> Term:
    """A set of a shape somewhere in a universe."""
    width = high - low

    def at(n: int) -> list[float]:
        return sorted(rng.uniform(low - 0.2 * width, high + 0.2 * width, n).tolist())

    def size(a: float = 0.05, b: float = 0.6) -> float:
        return float(rng.uniform(a, b) * width)

    def slope() -> float:
        return float(rng.uniform(2.0, 20.0) / width * rng.choice([-1.0, 1.0]))

    x = float(rng.uniform(low, high))
    if shape == "triangle":
        p = at(3)
        if rng.random() < 0.1:
            p = [-np.inf, *p[1:]] if rng.random() < 0.5 else [*p[:2], np.inf]
    elif shape in ("trapezoid", "pi_shape"):
        p = at(4)
        if shape == "trapezoid" and rng.random() < 0.2:
            p = [-np.inf, *p[1:]] if rng.random() < 0.5 else [*p[:3], np.inf]
    elif shape in ("ramp", "concave"):
        p = at(2) if rng.random() < 0.5 else at(2)[::-1]
    elif shape in ("rectangle", "s_shape", "z_shape"):
        p = at(2)
    elif shape == "binary":
        p = [x, float(rng.choice([-np.inf, np.inf]))]
    elif shape in ("gaussian", "cosine", "spike"):
        p = [x, size()]
    elif shape == "gaussian_product":
        a, b = at(2)
        p = [a, size(), b, size()]
    elif shape == "bell":
        p = [x, size(), float(rng.uniform(0.5, 5.0))]
    elif shape == "sigmoid":
        p = [x, slope()]
    elif shape in ("sigmoid_difference", "sigmoid_product"):
        a, b = at(2)
        sign = 1.0 if shape == "sigmoid_difference" else -1.0
        p = [a, abs(slope()), sign * abs(slope()), b]
    elif shape == "discrete":
        xs = at(int(rng.integers(2, 7)))
        p = [v for pair in zip(xs, rng.uniform(0, 1, len(xs)).tolist(), strict=True) for v in pair]
    else:
        raise ValueError(shape)
    tall = float(rng.uniform(0.2, 1.0)) if height and rng.random() < 0.15 else 1.0
    return Term(name, shape, tuple(p), tall)


def partition(name: str, rng, low: float, high: float) -> tuple[Term, ...]:
    """A triangular partition, shouldered or not."""
    n = int(rng.integers(2, 8))
    c = [low, *sorted(rng.uniform(low, high, n - 2).tolist()), high]
    outer = [-np.inf, np.inf] if rng.random() < 0.5 else [low - 1.0, high + 1.0]
    feet = [outer[0], *c, outer[1]]
    return tuple(Term(f"{name}{i}", "triangle", tuple(feet[i : i + 3])) for i in range(n))


def _universe(rng) -> tuple[float, float]:
    low = float(np.round(rng.uniform(-10, 5), 3))
    return low, float(np.round(low + rng.uniform(0.5, 20), 3))


def _input(rng, number: int) -> Input:
    low, high = _universe(rng)
    if rng.random() < 0.3:
        terms = partition("p", rng, low, high)
    else:
        shapes = rng.choice(SETS, int(rng.integers(1, 5)))
        terms = tuple(term(rng, f"t{i}", str(s), low, high) for i, s in enumerate(shapes))
    return Input(f"x{number}", low, high, terms, lock_range=bool(rng.random() < 0.2), enabled=bool(rng.random() < 0.95))


def _output(rng, number: int, kind: str, inputs: int) -> Output:
    low, high = _universe(rng)
    count = int(rng.integers(1, 6))
    default = float(np.round(rng.uniform(low, high), 2)) if rng.random() < 0.5 else float("nan")
    common = {
        "default": default,
        "lock_previous": bool(rng.random() < 0.15),
        "lock_range": bool(rng.random() < 0.2),
    }
    if kind in ("mamdani", "larsen"):
        if rng.random() < 0.3:
            terms = partition("u", rng, low, high)
        else:
            terms = tuple(term(rng, f"u{i}", str(rng.choice(SETS)), low, high) for i in range(count))
        aggregation = "maximum" if rng.random() < 0.5 else str(rng.choice(S_NORMS))
        return Output(f"y{number}", low, high, terms, aggregation=aggregation, defuzzifier=str(rng.choice(INTEGRAL)),
                      resolution=int(rng.integers(10, 220)), **common)  # fmt: skip
    if kind == "zero order":
        terms = tuple(Term(f"u{i}", "constant", (float(rng.uniform(low, high)),)) for i in range(count))
    elif kind == "first order":
        terms = tuple(Term(f"u{i}", "linear", tuple(rng.normal(size=inputs + 1).tolist())) for i in range(count))
    elif kind == "tsukamoto":
        terms = tuple(term(rng, f"u{i}", str(rng.choice(["ramp", "sigmoid"])), low, high, False) for i in range(count))
    else:
        plain = ("triangle", "trapezoid", "gaussian", "bell", "cosine", "rectangle")
        terms = tuple(term(rng, f"u{i}", str(rng.choice(plain)), 0.0, 1.0) for i in range(count))
    return Output(f"y{number}", low, high, terms, aggregation=None,
                  defuzzifier=str(rng.choice(["weighted_average", "weighted_sum"])), **common)  # fmt: skip


def _hedges(rng) -> tuple[str, ...]:
    if rng.random() < 0.75:
        return ()
    return tuple(str(h) for h in rng.choice([h for h in HEDGES if h != "any"], int(rng.integers(1, 3))))


def _antecedent(rng, inputs):
    props = []
    for v in inputs:
        if rng.random() < 0.8 or not props:
            if rng.random() < 0.04:
                props.append(Is(v.name, "", ("any",)))
            else:
                props.append(Is(v.name, str(rng.choice([t.name for t in v.terms])), _hedges(rng)))
    while len(props) > 1:
        i = int(rng.integers(len(props) - 1))
        props[i : i + 2] = [(And if rng.random() < 0.6 else Or)(props[i], props[i + 1])]
    return props[0]


def _activation(rng) -> tuple[str, tuple[str, ...]]:
    if rng.random() < 0.6:
        return "general", ()
    name = str(rng.choice(["first", "last", "highest", "lowest", "proportional", "threshold"]))
    if name in ("first", "last"):
        return name, (str(int(rng.integers(1, 4))), repr(float(np.round(rng.uniform(0, 0.6), 2))))
    if name in ("highest", "lowest"):
        return name, (str(int(rng.integers(1, 4))),)
    if name == "threshold":
        return name, (str(rng.choice([">", ">=", "<", "<=", "!="])), repr(float(np.round(rng.uniform(0.1, 0.7), 2))))
    return name, ()


def _block(rng, number: int, inputs, outputs, kind: str) -> RuleBlock:
    def consequents():
        wanted = [o for o in outputs if rng.random() < 0.7] or [outputs[0]]
        made = [Is(o.name, str(rng.choice([t.name for t in o.terms]))) for o in wanted]
        # fuzzylite puts the hedges of one consequent on those behind it as well; the last has none behind it
        # and it has no inverse of a sigmoid at 0 and above 1 (NaN): no hedges and no sums there
        hedges = () if kind == "tsukamoto" else _hedges(rng)
        return (*made[:-1], Is(made[-1].variable, made[-1].term, hedges))

    if rng.random() < 0.2 and all(len(v.terms) > 1 for v in inputs) and len(inputs) == 2:
        ways = [And(Is("x0", a.name), Is("x1", b.name)) for a in inputs[0].terms for b in inputs[1].terms]
    else:
        ways = [_antecedent(rng, inputs) for _ in range(int(rng.integers(1, 9)))]
    rules = tuple(
        Rule(w, consequents(), 1.0 if rng.random() < 0.7 else float(np.round(rng.uniform(0, 1), 2))) for w in ways
    )
    activation, parameters = _activation(rng)
    return RuleBlock(rules, f"b{number}", str(rng.choice(T_NORMS)),
                     "maximum" if kind == "tsukamoto" else str(rng.choice(DUALS)),
                     str(rng.choice(["minimum", "algebraic_product", *T_NORMS])), activation, parameters)  # fmt: skip


def system(seed: int) -> System:
    """The system of a seed."""
    rng = np.random.default_rng(seed)
    inputs = tuple(_input(rng, i) for i in range(int(rng.integers(1, 4))))
    kind = KINDS[seed % len(KINDS)]
    outputs = tuple(_output(rng, i, kind, len(inputs)) for i in range(int(rng.integers(1, 3))))
    blocks = tuple(_block(rng, i, inputs, outputs, kind) for i in range(1 if rng.random() < 0.8 else 2))
    return System(f"s{seed}", inputs, outputs, blocks)


def points(made: System, count: int, seed: int) -> np.ndarray:
    """Points inside and a little outside the universes, some on the parameters of the terms."""
    rng = np.random.default_rng(seed)
    columns = []
    for v in made.inputs:
        width = v.high - v.low
        x = rng.uniform(v.low - 0.1 * width, v.high + 0.1 * width, count)
        marks = [p for t in v.terms for p in t.parameters if v.low <= p <= v.high] or [v.low]
        x = np.where(rng.random(count) < 0.1, rng.choice(marks, count), x)
        columns.append(x)
    return np.column_stack(columns)
