"""How each machine is operated, one file a study; :mod:`~leadscrew.operate.profiles.general` for every other one."""

OWN = ("vud_lathe", "grey_turning", "fsmc_ballscrew", "sofnn_tangent", "npid_xytable")
"""Studies that have a profile of their own."""
