"""Design of a controller from a log of the one that it replaces."""

from leadscrew.design.factors import Factors
from leadscrew.design.files import read_moves
from leadscrew.design.log import Move, MoveLog
from leadscrew.design.vud import VudDesign, design_vud

__all__ = ["Factors", "Move", "MoveLog", "VudDesign", "design_vud", "read_moves"]
