"""The published turning forces as a file: what ``leadscrew identify cutting-force FILE --example`` writes."""

EXAMPLE = """\
# Main cutting force in dry turning, about 1080 1/min: published facts, from mati-paredes/Turning-Cutting-Forces.
# Four feeds at a depth of 1 mm, four depths at a feed of 0.104 mm/rev; the cut at 0.104 mm/rev and 1 mm is in both.
# "feed" is what was set at the lathe, "measured feed" is length over time and spindle speed, as its authors took it.
# Their own fit, to the four feeds as measured: specific force 1609.5 N/mm2 at 1 mm, exponent 0.136, R2 0.932.
feed (mm/rev),measured feed (mm/rev),depth (mm),force (N)
0.104,0.098,1.0,212.6
0.187,0.176,1.0,371.1
0.299,0.303,1.0,569.0
0.416,0.401,1.0,725.6
0.104,0.102,0.25,65.5
0.104,0.100,0.5,120.2
0.104,0.098,1.0,212.6
0.104,0.101,1.25,268.2
"""
"""Eight facts of mati-paredes/Turning-Cutting-Forces; the same as ``examples/turning_forces.csv``."""
