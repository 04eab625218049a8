"""Starts in penetration: cases, and the judge of their runs."""
