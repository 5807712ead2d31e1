"""scikit-fuzzy: Mamdani systems of triangles, universes of 101 points, its cache of repeated inputs off."""

import numpy as np
import skfuzzy as fuzz
from common import serve
from skfuzzy import control


def made(request):
    given = request["system"]

    def variable(kind, v):
        made = kind(np.linspace(v["low"], v["high"], 101), v["name"])
        for name, abc in v["terms"].items():
            made[name] = fuzz.trimf(made.universe, abc)
        return made

    inputs = [variable(control.Antecedent, v) for v in given["inputs"]]
    output = variable(control.Consequent, given["output"])
    rules = []
    for terms, then in given["rules"]:
        asked = inputs[0][terms[0]]
        for v, t in zip(inputs[1:], terms[1:], strict=True):
            asked = asked & v[t]
        rules.append(control.Rule(asked, output[then]))
    simulation = control.ControlSystemSimulation(control.ControlSystem(rules), cache=False)

    def evaluate(point):
        for v, x in zip(given["inputs"], point, strict=True):
            simulation.input[v["name"]] = x
        simulation.compute()
        return [float(simulation.output[given["output"]["name"]])]

    return evaluate, None


serve("scikit-fuzzy", made)
