"""What the programs of this folder share."""

import json
import sys
import time
from importlib.metadata import version


def serve(package, made):
    """``made(request)`` gives ``evaluate(point) -> outputs`` and ``many(points)`` or ``None``."""
    request = json.load(sys.stdin)
    evaluate, many = made(request)
    everything = request["points"]
    points = everything[: request["single"]]
    half = max(1, len(points) // 2)
    evaluate(points[0])
    outputs, times = [], []
    for part in (points[:half], points[half:]):
        began = time.process_time()
        found = [evaluate(p) for p in part]
        times.append((time.process_time() - began) / max(1, len(part)))
        outputs += found
    answer = {"ns": min(t for t in times if t > 0.0) * 1e9, "outputs": outputs, "version": version(package)}
    if many is not None:
        many(everything)
        times = []
        for _ in range(3):
            began = time.process_time()
            many(everything)
            times.append((time.process_time() - began) / len(everything))
        answer["many_ns"] = min(times) * 1e9
    print("\n" + json.dumps(answer))  # some print on their own: the answer is the last line
