"""AMASS npz in its SMPL-X, SMPL-H and SMPL layouts."""
