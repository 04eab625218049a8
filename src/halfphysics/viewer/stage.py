"""One result in a viser scene: people, ghosts, objects and static geometry."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.errors import InputError
from halfphysics.geometry.mesh_queries import is_closed
from halfphysics.render import outlines
from halfphysics.render.creases import split
from halfphysics.render.ghost import Separation
from halfphysics.render.look import EDGE_WIDTH, GLASS_ALPHA
from halfphysics.render.rasterizer import Camera, linear
from halfphysics.render.result_meshes import Drawing, Item
from halfphysics.render.viewpoint import FOV
from halfphysics.viewer.bones import GRAIN
from halfphysics.viewer.dents import DentNodes, SoftNode
from halfphysics.viewer.figure import Figure, moving_joints, rgb
from halfphysics.viewer.lights import Lights

if TYPE_CHECKING:
    from halfphysics.results.result import Result

Array = NDArray[np.float64]

# The ground is translucent grey: darker than a light page, lighter than a dark one. Its colour, the
# opacities of the plane, of its lines every half metre and every metre, and of shadows.
_GROUND, _PLANE, _CELL, _SECTION, _SHADOW = (118, 126, 138), 0.24, 0.3, 0.6, 0.45
# A mesh of more faces is shaded flat: finding its sharp edges would take seconds.
_MOST_SPLIT = 60_000
# The ground fades out at this distance from the camera, for a story of no extent [m].
_HORIZON = 26.0
_KINDS = ("person", "ghost")


@dataclass(eq=False)
class Layer:
    """Parts of a scene that are shown and hidden together.

    Attributes:
        label: Name in the panel.
        parts: Objects with a `visible`: viser's handles, figures.
    """

    label: str
    parts: list[Any] = field(default_factory=list)
    _visible: bool = True

    @property
    def visible(self) -> bool:
        """Whether the layer is shown."""
        return self._visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        self._visible = bool(visible)
        for part in self.parts:
            part.visible = self._visible


class Stage:
    """A result as nodes of a viser scene.

    Nodes are called `PREFIX/person/0`, `PREFIX/ghost/0`, `PREFIX/object/NAME` and
    `PREFIX/static/NAME`, as in `Drawing`.

    Args:
        server: The viser server.
        result: The result to show, or its `Drawing`.
        prefix: Path of the parent node of all nodes, such as "/second"; empty: the root.
        offset: Position of that node (3,) [m]; needs a prefix.
        faint: Names of statics (`static/NAME`) to draw translucent.
        without: Names of statics to leave out.
        live: Give every joint a bone, for poses that are not in the result.
        figure: Function that creates people and ghosts, with the arguments of `Figure`.
        dents: Send the vertices of soft things as they dent; not for a page, whose script has them.

    Attributes:
        drawing: The drawing of the result.
        prefix, offset: As given.
        layers: Name -> `Layer`: "body", "ghost", "objects" and "scene", without empty ones; more
            may be added.
        people, ghosts: A `Figure` for each person.
        followers: Functions that `show` calls with the frame, to update other content.
        frame: The last frame that `show` showed; -1: none yet.
    """

    def __init__(
        self,
        server: Any,
        result: Result | Drawing,
        prefix: str = "",
        offset: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        faint: Collection[str] = (),
        without: Collection[str] = (),
        live: bool = False,
        figure: Callable[..., Figure] = Figure,
        dents: bool = True,
    ) -> None:
        self.drawing = result if isinstance(result, Drawing) else Drawing(result)
        self.prefix, self.offset = prefix, np.asarray(offset, dtype=np.float64)
        if self.offset.any() and not prefix:
            raise InputError("offset: found one without a prefix, expected a node to move")
        self.frame = -1
        self.followers: list[Callable[[int], None]] = []
        self._server = server
        self._lock = threading.RLock()
        self._root = None
        if prefix:
            self._root = server.scene.add_frame(
                prefix, show_axes=False, position=tuple(self.offset)
            )
        self._add_items(faint, without)
        self._add_people(figure, live)
        layers = {
            "body": Layer("Body", [*self.people]),
            "ghost": Layer("Ghost", [*self.ghosts]),
            "objects": Layer("Objects", [*self._objects.values()]),
            "scene": Layer("Scene", [*self._statics.values(), *self._edges]),
        }
        self.layers = {name: layer for name, layer in layers.items() if layer.parts}
        soft = self.soft_items()
        if dents and soft:
            self.followers.append(DentNodes(soft).show)

    def _add_items(self, faint: Collection[str], without: Collection[str]) -> None:
        """Add the meshes of static geometry and of objects."""
        drawing = self.drawing
        self._statics = {
            name.removeprefix("static/"): self._add_static(name, item, name in faint)
            for name, item in drawing.statics.items()
            if name not in without
        }
        self._edges = self._add_edges(without)
        self._objects = {
            name.removeprefix("object/"): add_mesh(self._server, self.path(name), item, None)
            for name, item in drawing.objects.items()
        }
        self._tracks = {
            name: (
                _grain(drawing.objects[f"object/{name}"].position),
                _grain(drawing.objects[f"object/{name}"].quaternion),
            )
            for name in self._objects
        }

    def _add_people(self, figure: Callable[..., Figure], live: bool) -> None:
        """Add a figure and a ghost for every person."""
        self._frames: list[tuple[tuple[Array, Array], ...]] = []
        self._joints: list[Array] = []
        self._apart: list[Separation] = []
        # Per person: is it the ghost -> its pose.
        self._poses: list[dict[bool, tuple[Array, Array]]] = []
        self.people: list[Figure] = []
        self.ghosts: list[Figure] = []
        for k, person in enumerate(self.drawing.result.people):
            motions = (person.motion, person.recorded)
            frames = tuple(person.body.joint_frames(motion) for motion in motions)
            joints = None if live else moving_joints(*(q for _, q in frames))
            for kind, figures in zip(_KINDS, (self.people, self.ghosts), strict=True):
                skin = self.drawing.skin(k, kind == "ghost")
                name = self.path(f"{kind}/{k}")
                figures.append(figure(self._server, name, skin, person.body, joints, person=k))
            self._frames.append(frames)
            self._apart.append(Separation(person.body))
            self._poses.append({})
            self._joints.append(frames[0][0][0])

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.drawing)

    def path(self, name: str) -> str:
        """A node's path under the prefix."""
        return f"{self.prefix}/{name}"

    def show(self, frame: int) -> None:
        """Show a frame, clipped to the first and the last."""
        frame = min(max(int(frame), 0), len(self) - 1)
        with self._lock, self._server.atomic():
            for k, frames in enumerate(self._frames):
                for kind, (positions, quaternions) in zip(_KINDS, frames, strict=True):
                    self.pose(k, positions[frame], quaternions[frame], ghost=kind == "ghost")
            for name, (position, quaternion) in self._tracks.items():
                self.place(name, position[frame], quaternion[frame])
            self.frame = frame
            for follow in self.followers:
                follow(frame)

    def pose(
        self, person: int, positions: Array, quaternions: Array, *, ghost: bool = False
    ) -> None:
        """Move one person or ghost. A ghost fades by the person's pose: move the person first.

        Args:
            person: Index of the person.
            positions: World positions of the joints (55, 3) [m], from `Body.joint_frames`.
            quaternions: World quaternions of the joints, wxyz (55, 4).
            ghost: Move the ghost instead.
        """
        with self._lock:
            (self.ghosts if ghost else self.people)[person].pose(positions, quaternions)
            if not ghost:
                self._joints[person] = positions
            poses = self._poses[person]
            poses[ghost] = positions, quaternions
            if ghost and len(poses) == 2:
                self.ghosts[person].fade(self._apart[person].of(poses[False], poses[True]))

    def joints(self) -> list[Array]:
        """Joints of each person in the present pose (55, 3) [m], in the frame of the prefix."""
        with self._lock:
            return list(self._joints)

    def place(self, name: str, position: Array, quaternion: Array) -> None:
        """Move an object: `position` (3,) [m] and `quaternion` (4,) wxyz in the world.

        Raises:
            InputError: There is no such object.
        """
        if name not in self._objects:
            raise InputError(
                f"object: found {name!r}, expected one of {', '.join(self._objects) or 'none'}"
            )
        with self._lock:
            handle = self._objects[name]
            handle.position, handle.wxyz = position, quaternion

    def object(self, name: str) -> Any:
        """viser's handle of an object, for example to make it clickable."""
        return self._objects[name]

    def static(self, name: str) -> Any:
        """viser's handle of a static."""
        return self._statics[name]

    def soft_items(self) -> list[SoftNode]:
        """The soft items that something presses."""
        nodes = [
            *((f"static/{name}", handle) for name, handle in self._statics.items()),
            *((f"object/{name}", handle) for name, handle in self._objects.items()),
        ]
        found = []
        for name, handle in nodes:
            item = {**self.drawing.statics, **self.drawing.objects}[name]
            if item.dent is not None:
                found.append(SoftNode(name, item.surface, item.dent, handle))
        return found

    def draws(self, name: str) -> bool:
        """Whether there is a node for a static."""
        return name in self._statics

    @property
    def visible(self) -> bool:
        """Whether the stage is drawn; it can only be hidden with a prefix."""
        return self._root is None or self._root.visible

    @visible.setter
    def visible(self, visible: bool) -> None:
        if self._root is None:
            raise InputError("visible: this stage has no prefix to hide; hide its layers")
        self._root.visible = visible

    def _add_static(self, name: str, item: Item, faint: bool) -> Any:
        if item.surface.fade is not None and item.dent is None:
            return _add_floor(self._server, self.path(name), item, self.drawing)
        return add_mesh(
            self._server,
            self.path(name),
            item,
            GLASS_ALPHA if faint and item.dent is None else None,
        )

    def _add_edges(self, without: Collection[str]) -> list[Any]:
        """Add the edges of all statics as one node; none: there are no edges."""
        found, colors = [], []
        for name, item in self.drawing.statics.items():
            # Those of a soft thing would stay where they are as it dents.
            if name not in without and item.surface.cull != "back" and item.dent is None:
                found.append(outlines.edges(item.at(0)))
                # viser takes these colours as linear light.
                light = np.rint(
                    255 * linear(outlines.shade(item.surface.color, self.drawing.theme))
                )
                shade = light.astype(np.uint8)
                colors.append(np.broadcast_to(shade, found[-1].shape))
        segments = np.concatenate(found) if found else np.zeros((0, 2, 3))
        if not len(segments):
            return []
        node = self._server.scene.add_line_segments(
            self.path("edges"),
            segments,
            np.concatenate(colors),
            thickness=EDGE_WIDTH,
            thickness_units="screen",
        )
        return [node]


def middle(stages: Sequence[Stage]) -> Array:
    """Mean of the people's pelvises in the present poses, in the world (3,) [m]."""
    result: Array = np.mean(
        [p[0] + stage.offset for stage in stages for p in stage.joints()], axis=0
    )
    return result


def light(server: Any, direction: Sequence[float] = (0.0, -1.0, 0.0), reach: float = 0.0) -> Lights:
    """Add the lights; the arguments are those of `Lights`."""
    return Lights(server, (direction[0], direction[1], direction[2]), reach)


def aim(server: Any, camera: Camera) -> None:
    """Set the initial camera of new browsers."""
    server.initial_camera.position = tuple(camera.position)
    server.initial_camera.look_at = tuple(camera.target)
    server.initial_camera.up = (0.0, 0.0, 1.0)
    server.initial_camera.fov = math.radians(FOV)


def add_mesh(server: Any, name: str, item: Item, opacity: float | None) -> Any:
    """Add the mesh of an item at its first pose; `opacity` below 1: translucent."""
    surface = item.surface
    # A closed mesh is drawn one-sided: no shadow stripes, and one layer if translucent.
    solid = is_closed(surface.faces, len(surface.vertices))
    vertices, faces = surface.vertices, surface.faces
    flat = surface.crease < 180.0 and len(faces) > _MOST_SPLIT
    if surface.crease < 180.0 and not flat:
        vertices, faces = split(vertices, faces, surface.crease)
    return server.scene.add_mesh_simple(
        name,
        vertices,
        faces,
        color=rgb(surface.color),
        opacity=opacity,
        flat_shading=flat,
        side="front" if surface.cull == "back" or solid else "double",
        cast_shadow=opacity is None and surface.casts,
        position=tuple(item.position[0]),
        wxyz=tuple(item.quaternion[0]),
    )


def _add_floor(server: Any, name: str, item: Item, drawing: Drawing) -> Any:
    corners = item.surface.vertices
    return server.scene.add_grid(
        name,
        # Beyond the fading, so that no camera sees its border.
        width=float(np.linalg.norm(corners[1] - corners[0])) + 4.0 * _HORIZON,
        height=float(np.linalg.norm(corners[3] - corners[0])) + 4.0 * _HORIZON,
        cell_size=0.5,
        section_size=1.0,
        cell_color=_GROUND,
        cell_thickness=_CELL,
        section_color=_GROUND,
        section_thickness=_SECTION,
        plane_color=_GROUND,
        plane_opacity=_PLANE,
        shadow_opacity=_SHADOW,
        fade_distance=2.0 * drawing.radius + _HORIZON,
        position=tuple(corners.mean(axis=0)),
        wxyz=_upright(corners),
    )


def _upright(corners: Array) -> Array:
    """Quaternion that rotates the x-y plane into the square of these corners."""
    x = corners[1] - corners[0]
    y = corners[3] - corners[0]
    axes = [x / np.linalg.norm(x), y / np.linalg.norm(y)]
    return rot.from_matrix(np.stack([*axes, np.cross(*axes)], axis=1))


def _grain(values: Array) -> Array:
    return np.round(values / GRAIN) * GRAIN
