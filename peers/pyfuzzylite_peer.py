"""pyfuzzylite: the system as .fll text."""

import fuzzylite as fl
import numpy as np
from common import serve


def made(request):
    engine = fl.FllImporter().from_string(request["fll"])
    inputs, outputs = engine.input_variables, engine.output_variables

    def evaluate(point):
        for variable, x in zip(inputs, point, strict=True):
            variable.value = x
        engine.process()
        return [float(v.value) for v in outputs]

    def many(points):
        for variable, column in zip(inputs, np.array(points).T, strict=True):
            variable.value = column
        engine.process()

    return evaluate, many


serve("pyfuzzylite", made)
