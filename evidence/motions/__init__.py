"""Motions for whoever has none, made from a seed, and those of the user's."""
