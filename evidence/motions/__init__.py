"""Motions made from a seed, and motions of the user."""
