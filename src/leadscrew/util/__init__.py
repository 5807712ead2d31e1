"""What the rest is written with: errors, atomic files and folders, reading within limits, escaping."""
