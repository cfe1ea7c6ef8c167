"""The loop in which minds meet the world, and its record."""
