"""Authored recordings of people who carry things, and figures of what becomes of them simulated."""
