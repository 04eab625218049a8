"""The same motion and scene in plain MuJoCo: baselines to compare with, see docs/physics.md."""
