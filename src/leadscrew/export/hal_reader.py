"""Reads what ``sampler`` has sampled, exactly: run by the Python that LinuxCNC's ``hal`` module belongs to.

``halsampler`` prints six decimals, which is no basis for a comparison of bits.
"""

import array
import sys
import time


def main(rows, kinds, file):
    """Writes so many rows of the first sampler FIFO to a file of doubles, row by row."""
    import hal

    component = hal.component("leadscrew-reader")
    stream = hal.stream(component, hal.sampler_base, kinds)
    component.ready()
    numbers = array.array("d")
    for _ in range(rows):
        while not stream.readable:
            time.sleep(0.001)
        numbers.extend(float(x) for x in stream.read())
    with open(file, "wb") as out:  # noqa: PTH123
        numbers.tofile(out)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2], sys.argv[3])
