"""References: blocks that give the command, one file each. A scalar command, a :class:`Motion`, or a path point."""
