"""Starts inside things: cases, and the judge of what comes of them."""
