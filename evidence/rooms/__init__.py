"""Furnished rooms made from a seed, visits to them, and an independent check of the results."""
