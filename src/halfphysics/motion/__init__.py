"""SMPL-X motion: the skeleton, poses and motions."""
