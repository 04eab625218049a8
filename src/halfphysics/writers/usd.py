"""USD (.usd, .usdc, .usda, .usdz): skinned people and rigid props, animated. Needs usd-core.

z-up, metres, one time code per frame. Below "/World" are every person (a SkelRoot with skeleton,
skin and animation; joints named as `JOINT_NAMES`) and every prop (an Xform with a mesh). The points
of a soft prop move where it is pressed. The skinning of UsdSkel is that of SMPL without pose blend
shapes; if a body has them, they are blend shapes (`correctives`), which UsdSkel applies before the
skinning, as required.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.atomic import atomic_write
from halfphysics.body.body import Body
from halfphysics.errors import MissingDependencyError
from halfphysics.motion.skeleton import JOINT_NAMES, N_JOINTS, PARENTS
from halfphysics.render.rasterizer import Color
from halfphysics.render.result_meshes import CREASE
from halfphysics.writers.colors import actors_coloured, linear, props_coloured
from halfphysics.writers.correctives import correctives
from halfphysics.writers.dent_shapes import MovingSurface, moving_surface
from halfphysics.writers.normals import creased, vertex_normals
from halfphysics.writers.take import Actor, Prop, Take
from halfphysics.writers.usd_colliders import Colliders

Array = NDArray[np.float64]

# A zip stores the local time of its content: a fixed time, so that the same take gives the same
# bytes.
_STAMP = time.mktime((1980, 1, 2, 0, 0, 0, 0, 0, -1))
_ROOT, _LOOKS = "/World", "/World/Looks"


def write(take: Take, path: Path, *, colliders: bool = False) -> None:
    """Write a take; with `colliders` also bodies that physics engines collide with.

    Raises:
        MissingDependencyError: usd-core is not installed.
        FileError: The folder does not exist or cannot be written.
    """
    pxr = _pxr()
    builder = _Builder(pxr, take)
    bodies = None
    if colliders:
        bodies = Colliders(pxr, builder.stage, take, builder.new_path("PhysicsScene"))
    for actor, color in actors_coloured(take.actors):
        where = builder.add_actor(actor, color)
        if bodies is not None:
            bodies.add_actor(actor, builder.new_path(f"{where.rsplit('/', 1)[1]}Colliders"))
    for prop, color in props_coloured(take.props):
        where = builder.add_prop(prop, color)
        if bodies is not None:
            bodies.add_prop(prop, where)
    suffix = path.suffix.lower()
    with atomic_write(path) as handle, tempfile.TemporaryDirectory() as folder:
        # USD writes only to a path, and takes the format from its suffix.
        made = Path(folder) / f"take{'.usdc' if suffix == '.usdz' else suffix}"
        builder.stage.GetRootLayer().Export(str(made))
        if suffix == ".usdz":
            os.utime(made, (_STAMP, _STAMP))
            package = made.with_suffix(".usdz")
            pxr.UsdUtils.CreateNewUsdzPackage(pxr.Sdf.AssetPath(str(made)), str(package))
            made = package
        handle.write(made.read_bytes())


def _pxr() -> Any:
    """The modules of usd-core."""
    try:
        from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdSkel, UsdUtils, Vt
    except ImportError as error:
        raise MissingDependencyError(
            "writing USD needs usd-core: pip install 'halfphysics[usd]' (or pip install usd-core)"
        ) from error
    return SimpleNamespace(
        Gf=Gf,
        Sdf=Sdf,
        Tf=Tf,
        Usd=Usd,
        UsdGeom=UsdGeom,
        UsdShade=UsdShade,
        UsdSkel=UsdSkel,
        UsdUtils=UsdUtils,
        Vt=Vt,
    )


class _Builder:
    """Adds people and props to a stage."""

    def __init__(self, pxr: Any, take: Take) -> None:
        self.pxr = pxr
        self.stage = stage = pxr.Usd.Stage.CreateInMemory()
        pxr.UsdGeom.SetStageUpAxis(stage, pxr.UsdGeom.Tokens.z)
        pxr.UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetTimeCodesPerSecond(take.fps)
        stage.SetFramesPerSecond(take.fps)
        stage.SetStartTimeCode(0)
        stage.SetEndTimeCode(take.frames - 1)
        stage.SetDefaultPrim(pxr.UsdGeom.Xform.Define(stage, _ROOT).GetPrim())
        pxr.UsdGeom.Scope.Define(stage, _LOOKS)
        self._taken = {_LOOKS}

    # -- people --------------------------------------------------------------------------------

    def add_actor(self, actor: Actor, color: Color) -> str:
        """Add a person: a skeleton, its skin and their animation. Returns its path."""
        skel, body = self.pxr.UsdSkel, actor.body
        path = self.new_path(actor.name)
        root = skel.Root.Define(self.stage, path)
        root.GetPrim().SetDisplayName(actor.name)
        root.CreateExtentAttr(self._points(_reach(actor)))

        joints = self._joint_paths()
        skeleton = skel.Skeleton.Define(self.stage, f"{path}/Skeleton")
        skeleton.CreateJointsAttr(joints)
        skeleton.CreateBindTransformsAttr(self._shifts(body.rest_joints))
        arms = body.rest_joints - body.rest_joints[np.maximum(PARENTS, 0)]
        arms[0] = body.rest_joints[0]
        skeleton.CreateRestTransformsAttr(self._shifts(arms))

        animation = skel.Animation.Define(self.stage, f"{path}/Animation")
        animation.CreateJointsAttr(joints)
        self._animate_joints(animation, actor, arms)
        binding = skel.BindingAPI.Apply(skeleton.GetPrim())
        binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])

        normals = vertex_normals(body.rest_vertices, body.faces)
        mesh = self._mesh(f"{path}/Skin", body.rest_vertices, body.faces, normals)
        self._paint(mesh, path, color)
        binding = skel.BindingAPI.Apply(mesh.GetPrim())
        binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
        binding.CreateGeomBindTransformAttr(self.pxr.Gf.Matrix4d(1.0))
        indices, weights = _influences(body)
        count = indices.shape[1]
        vt = self.pxr.Vt
        binding.CreateJointIndicesPrimvar(False, count).Set(vt.IntArray.FromNumpy(indices.ravel()))
        binding.CreateJointWeightsPrimvar(False, count).Set(
            vt.FloatArray.FromNumpy(weights.ravel())
        )
        if body.posedirs is not None:
            self._add_correctives(mesh, binding, animation, actor, body.posedirs)
        return path

    def _joint_paths(self) -> list[str]:
        paths: list[str] = []
        for name, parent in zip(JOINT_NAMES, PARENTS, strict=True):
            paths.append(name if parent < 0 else f"{paths[parent]}/{name}")
        return paths

    def _animate_joints(self, animation: Any, actor: Actor, arms: Array) -> None:
        vt, motion = self.pxr.Vt, actor.motion
        places = np.tile(arms, (len(motion), 1, 1))
        places[:, 0] = actor.body.joint_frames(motion)[0][:, 0]
        turns = rot.continuous(rot.exp(motion.rotations))
        moved, turned = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
        ones = np.ones((N_JOINTS, 3), dtype=np.float16)
        animation.CreateScalesAttr(vt.Vec3hArray.FromNumpy(ones))
        for k in range(len(motion)):
            moved.Set(self._points(places[k]), k)
            xyzw = np.ascontiguousarray(turns[k][:, [1, 2, 3, 0]], dtype=np.float32)
            turned.Set(vt.QuatfArray.FromNumpy(xyzw), k)

    def _add_correctives(
        self, mesh: Any, binding: Any, animation: Any, actor: Actor, posedirs: Array
    ) -> None:
        shapes, weights = correctives(posedirs, actor.motion.rotations)
        if not len(shapes):
            return
        vt, names, targets = self.pxr.Vt, [], []
        for i, offsets in enumerate(shapes):
            names.append(f"pose{i}")
            shape = self.pxr.UsdSkel.BlendShape.Define(self.stage, f"{mesh.GetPath()}/pose{i}")
            shape.CreateOffsetsAttr(self._points(offsets))
            targets.append(shape.GetPath())
        binding.CreateBlendShapesAttr(names)
        binding.CreateBlendShapeTargetsRel().SetTargets(targets)
        animation.CreateBlendShapesAttr(names)
        attribute = animation.CreateBlendShapeWeightsAttr()
        for k, row in enumerate(weights.astype(np.float32)):
            attribute.Set(vt.FloatArray.FromNumpy(row), k)

    # -- props ---------------------------------------------------------------------------------

    def add_prop(self, prop: Prop, color: Color) -> str:
        """Add a prop: its mesh, with sharp edges, and its animation. Returns its path."""
        gf, path = self.pxr.Gf, self.new_path(prop.name)
        xform = self.pxr.UsdGeom.Xform.Define(self.stage, path)
        xform.GetPrim().SetDisplayName(prop.name)
        double = self.pxr.UsdGeom.XformOp.PrecisionDouble
        place, turn = xform.AddTranslateOp(double), xform.AddOrientOp(double)
        turns = rot.continuous(rot.normalize(prop.quaternion))
        for k, (p, q) in enumerate(zip(prop.position.tolist(), turns.tolist(), strict=True)):
            when = (k,) if prop.moves else ()
            place.Set(gf.Vec3d(*p), *when)
            turn.Set(gf.Quatd(*q), *when)
        if len(prop.faces):
            moving = None if prop.dent is None else moving_surface(prop.dent)
            if moving is None:
                vertices, faces, normals = creased(prop.vertices, prop.faces, CREASE)
            else:
                faces = moving.faces
                vertices, normals = moving.vertices, vertex_normals(moving.vertices, faces)
            mesh = self._mesh(f"{path}/Mesh", vertices, faces, normals)
            mesh.CreateDoubleSidedAttr(True)
            if moving is not None:
                self._animate_dents(mesh, moving)
            self._paint(mesh, path, color)
        return path

    def _animate_dents(self, mesh: Any, moving: MovingSurface) -> None:
        """Points and normals over time, where they differ from the frame before or after."""
        points, normals = mesh.GetPointsAttr(), mesh.GetNormalsAttr()
        depth = moving.dent.depth
        change = (depth[1:] != depth[:-1]).any(axis=1)
        wanted = np.append(change, False) | np.append(False, change)
        wanted[0] = True
        for frame in np.flatnonzero(wanted).tolist():
            vertices, turned = moving.at(frame)
            points.Set(self._points(vertices), frame)
            normals.Set(self._points(turned), frame)

    # -- shared parts --------------------------------------------------------------------------

    def new_path(self, name: str) -> str:
        """A new, unused prim path for `name`; nothing else gets it."""
        path = f"{_ROOT}/{self.pxr.Tf.MakeValidIdentifier(name)}"
        while path in self._taken:
            path += "_"
        self._taken.add(path)
        return path

    def _mesh(self, path: str, vertices: Array, faces: NDArray[np.integer], normals: Array) -> Any:
        vt, geom = self.pxr.Vt, self.pxr.UsdGeom
        mesh = geom.Mesh.Define(self.stage, path)
        mesh.CreatePointsAttr(self._points(vertices))
        counts = np.full(len(faces), 3, dtype=np.int32)
        mesh.CreateFaceVertexCountsAttr(vt.IntArray.FromNumpy(counts))
        corners = np.ascontiguousarray(faces.ravel(), dtype=np.int32)
        mesh.CreateFaceVertexIndicesAttr(vt.IntArray.FromNumpy(corners))
        mesh.CreateNormalsAttr(self._points(normals))
        mesh.SetNormalsInterpolation(geom.Tokens.vertex)
        mesh.CreateSubdivisionSchemeAttr(geom.Tokens.none)
        mesh.CreateExtentAttr(self._points(np.stack([vertices.min(axis=0), vertices.max(axis=0)])))
        return mesh

    def _paint(self, mesh: Any, path: str, color: Color) -> None:
        shade, types = self.pxr.UsdShade, self.pxr.Sdf.ValueTypeNames
        light = self.pxr.Gf.Vec3f(*linear(color))
        mesh.CreateDisplayColorAttr([light])
        material = shade.Material.Define(self.stage, f"{_LOOKS}/{path.rsplit('/', 1)[1]}")
        shader = shade.Shader.Define(self.stage, f"{material.GetPath()}/Surface")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", types.Color3f).Set(light)
        shader.CreateInput("roughness", types.Float).Set(0.8)
        material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
        shade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)

    def _points(self, values: Array) -> Any:
        return self.pxr.Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, dtype=np.float32))

    def _shifts(self, places: Array) -> Any:
        """USD matrices (for row vectors) of translations by `places` (n, 3)."""
        matrices = np.tile(np.eye(4), (len(places), 1, 1))
        matrices[:, 3, :3] = places
        return self.pxr.Vt.Matrix4dArray.FromNumpy(matrices)


def _influences(body: Body) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """All skinning joints (V, n) of each vertex and their weights."""
    count = int(np.count_nonzero(body.weights, axis=1).max())
    order = np.argsort(-body.weights, axis=1, kind="stable")[:, :count]
    values = np.take_along_axis(body.weights, order, axis=1)
    return np.where(values > 0.0, order, 0).astype(np.int32), values.astype(np.float32)


def _reach(actor: Actor) -> Array:
    """Corners (2, 3) of a box that contains the skin in all frames [m]."""
    body = actor.body
    nearest = body.rest_joints[body.weights.argmax(axis=1)]
    margin = 1.5 * float(np.linalg.norm(body.rest_vertices - nearest, axis=1).max())
    joints = body.joints(actor.motion).reshape(-1, 3)
    return np.stack([joints.min(axis=0) - margin, joints.max(axis=0) + margin])
