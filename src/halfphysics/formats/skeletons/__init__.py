"""Skeletons of other programs: names, rest poses and retargeting to SMPL-X."""
