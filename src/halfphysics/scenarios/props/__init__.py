"""Furniture and hand-held objects of the scenarios."""
