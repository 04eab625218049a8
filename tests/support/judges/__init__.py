"""Judges: they look at a result from outside, with another library or plain numpy."""
