"""The numbers of the paper.

"Half-Physics: Enabling Kinematic 3D Human Model with Physical Interactions". Errors in mm,
penetration rates and success in %, speed in frames/s.
"""

from __future__ import annotations

#: Table 1, AIST++ test, 40 sequences: success, MPJPE-g, MPJPE.
HALF_PHYSICS = (100.0, 0.003, 0.003)
#: Table 1, PHC+, a tracker that took seven days of training; on its successful runs.
PHC_PLUS = (92.5, 49.192, 34.467)
#: Table 2, TRUMANS, 20 test scenes, generated motions: rate, mean depth, largest depth.
GENERATED = (7.914, 82.10, 172.19)
PENETRATION = (0.0, 0.0, 0.0)
#: Table 3, joint torques instead of velocities: MPJPE-g, MPJPE.
TORQUE = (83.109, 82.273)
#: Table 4, with internal forces; with damping and internal forces: MPJPE-g, MPJPE.
INTERNAL = (145.524, 50.848)
DAMPED_INTERNAL = (148.802, 50.030)
#: Speed, on a Xeon E3-1280 v2 with a Quadro RTX 5000.
SPEED = 952.94
