"""BVH: skeletons, rest poses and retargeting to SMPL-X."""
