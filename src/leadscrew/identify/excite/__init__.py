"""Test moves: what an axis must do so that its log tells mass, friction, delay and lost motion, inside safe limits."""

from leadscrew.lazy import doors

__getattr__, __dir__ = doors(
    globals(),
    {
        "move": "Limits Move Sampled Stroke check sampled path_of",
        "belief": "Belief belief_of",
        "information": "Information information",
        "design": "candidates Predicted Proposal propose",
        "files": "write",
    },
)
