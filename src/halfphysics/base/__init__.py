"""Foundations of every layer: checks, rotations, axes, files, digests, worker processes."""
