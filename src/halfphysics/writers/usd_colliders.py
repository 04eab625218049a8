"""Bodies that other physics engines collide with, in a USD stage: UsdPhysics, for Isaac and Newton.

Beside every person is an Xform ``NAMEColliders`` with the convex hulls of its rigid parts, named as
the joints: each is a kinematic rigid body whose pose is animated like the joint's, so that a robot
is pushed by the person and never pushes it. Statics collide, things that move are kinematic as
recorded. The hulls are guides: they are not drawn.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.writers.take import Actor, Prop, Take

Array = NDArray[np.float64]


class Colliders:
    """Adds colliders to a stage.

    Args:
        pxr: The modules of usd-core (`usd`).
        stage: The stage.
        take: Whose gravity it is.
        path: Of the prim that says the gravity.
    """

    def __init__(self, pxr: Any, stage: Any, take: Take, path: str) -> None:
        from pxr import UsdPhysics

        self._pxr, self._stage, self._physics = pxr, stage, UsdPhysics
        scene = UsdPhysics.Scene.Define(stage, path)
        gravity = np.asarray(take.scene.gravity, dtype=np.float64)
        size = float(np.linalg.norm(gravity))
        down = gravity / size if size > 0.0 else np.array([0.0, 0.0, -1.0])
        scene.CreateGravityDirectionAttr(pxr.Gf.Vec3f(*down.tolist()))
        scene.CreateGravityMagnitudeAttr(size)

    def add_actor(self, actor: Actor, above: str) -> None:
        """The hulls of a person's rigid parts, in an Xform at the path `above`."""
        geom = self._pxr.UsdGeom
        geom.Xform.Define(self._stage, above)
        positions, quaternions = actor.body.joint_frames(actor.motion)
        turns = rot.continuous(quaternions)
        for part in actor.body.variant.parts:
            if not len(part.vertices):
                continue
            xform = geom.Xform.Define(self._stage, f"{above}/{part.name}")
            self._animate(xform, positions[:, part.index], turns[:, part.index])
            self._kinematic(xform.GetPrim())
            mass = self._physics.MassAPI.Apply(xform.GetPrim())
            mass.CreateMassAttr(float(part.mass))
            hull = self._hull(f"{above}/{part.name}/Hull", part.vertices, part.faces)
            self._collides(hull.GetPrim(), "convexHull")

    def add_prop(self, prop: Prop, path: str) -> None:
        """Make the mesh of a prop at `path` collide; one that moves is kinematic."""
        mesh = self._stage.GetPrimAtPath(f"{path}/Mesh")
        if not mesh:
            return
        if prop.moves:
            self._kinematic(self._stage.GetPrimAtPath(path))
        self._collides(mesh, "convexDecomposition" if prop.moves else "none")

    def _animate(self, xform: Any, positions: Array, turns: Array) -> None:
        gf = self._pxr.Gf
        double = self._pxr.UsdGeom.XformOp.PrecisionDouble
        place, turn = xform.AddTranslateOp(double), xform.AddOrientOp(double)
        for k, (p, q) in enumerate(zip(positions.tolist(), turns.tolist(), strict=True)):
            place.Set(gf.Vec3d(*p), k)
            turn.Set(gf.Quatd(*q), k)

    def _kinematic(self, prim: Any) -> None:
        body = self._physics.RigidBodyAPI.Apply(prim)
        body.CreateRigidBodyEnabledAttr(True)
        body.CreateKinematicEnabledAttr(True)

    def _collides(self, prim: Any, approximation: str) -> None:
        self._physics.CollisionAPI.Apply(prim).CreateCollisionEnabledAttr(True)
        shape = self._physics.MeshCollisionAPI.Apply(prim)
        shape.CreateApproximationAttr(approximation)

    def _hull(self, path: str, vertices: Array, faces: NDArray[np.integer]) -> Any:
        vt, geom = self._pxr.Vt, self._pxr.UsdGeom
        mesh = geom.Mesh.Define(self._stage, path)
        points = np.ascontiguousarray(vertices, dtype=np.float32)
        mesh.CreatePointsAttr(vt.Vec3fArray.FromNumpy(points))
        counts = np.full(len(faces), 3, dtype=np.int32)
        mesh.CreateFaceVertexCountsAttr(vt.IntArray.FromNumpy(counts))
        corners = np.ascontiguousarray(faces.ravel(), dtype=np.int32)
        mesh.CreateFaceVertexIndicesAttr(vt.IntArray.FromNumpy(corners))
        mesh.CreateSubdivisionSchemeAttr(geom.Tokens.none)
        box = np.stack([points.min(axis=0), points.max(axis=0)])
        mesh.CreateExtentAttr(vt.Vec3fArray.FromNumpy(box))
        mesh.CreatePurposeAttr(geom.Tokens.guide)
        return mesh
