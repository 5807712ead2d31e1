"""Study of a self-organising fuzzy neural network that compensates tangent-following errors in flexible material."""
