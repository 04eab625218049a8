"""What every layer stands on: checks, rotations, axes, files, digests, worker processes."""
