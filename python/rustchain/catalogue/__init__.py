"""Standard chains, and drives from a handful of numbers."""
