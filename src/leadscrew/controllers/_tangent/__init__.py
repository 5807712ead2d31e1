"""Controllers of a tangential axis beside the self-organising one: tables, observers, feed-forward of curvature."""
