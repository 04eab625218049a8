"""Furnished rooms made from a seed, who comes into them, and who checks what came of it."""
