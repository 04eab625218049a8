"""Judges of soft layers, which share no code with the core: formulas and a plain integrator."""
