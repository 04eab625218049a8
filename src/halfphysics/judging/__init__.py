"""Clips of files by everybody's measures (`halfphysics.metrics.judge`), in processes."""
