"""Recorded hands hold recorded things: a motion is fitted to what it was recorded with."""
