"""Design of a controller from a log of the one that it replaces."""

from leadscrew.design.files import Move, MoveLog, read_moves
from leadscrew.design.vud import VudDesign, design_vud
from leadscrew.design.vud_steps import Factors

__all__ = ["Factors", "Move", "MoveLog", "VudDesign", "design_vud", "read_moves"]
