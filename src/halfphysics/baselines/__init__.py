"""Other ways to put a motion into a simulation, to compare with: docs/physics.md, Baselines."""
