"""Judges: they check a result independently, with another library or plain numpy."""
