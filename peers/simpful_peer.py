"""simpful: triangles and constants, rules that are all ``and``."""

import simpful as sf
from common import serve


def made(request):
    given = request["system"]
    fs = sf.FuzzySystem(operators=["AND_PRODUCT"] if given["product"] else None, show_banner=False, verbose=False)
    for v in given["inputs"]:
        sets = [sf.FuzzySet(function=sf.Triangular_MF(*abc), term=name) for name, abc in v["terms"].items()]
        fs.add_linguistic_variable(v["name"], sf.LinguisticVariable(sets, universe_of_discourse=[v["low"], v["high"]]))
    out = given["output"]
    if out["constants"]:
        for name, value in out["constants"].items():
            fs.set_crisp_output_value(name, value)
    else:
        sets = [sf.FuzzySet(function=sf.Triangular_MF(*abc), term=name) for name, abc in out["terms"].items()]
        fs.add_linguistic_variable(
            out["name"], sf.LinguisticVariable(sets, universe_of_discourse=[out["low"], out["high"]])
        )
    names = [v["name"] for v in given["inputs"]]
    for terms, then in given["rules"]:
        asked = " AND ".join(f"({n} IS {t})" for n, t in zip(names, terms, strict=True))
        fs.add_rules([f"IF {asked} THEN ({out['name']} IS {then})"])

    def evaluate(point):
        for name, x in zip(names, point, strict=True):
            fs.set_variable(name, x)
        found = fs.Sugeno_inference() if out["constants"] else fs.Mamdani_inference()
        return [float(found[out["name"]])]

    return evaluate, None


serve("simpful", made)
