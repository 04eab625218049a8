"""The meshes of a result at a frame, with colours, for pictures and for the viewer.

The simulated person is solid, the reference is a translucent ghost; objects have strong colours.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from halfphysics.base import rotations as rot
from halfphysics.base.validation import is_whole
from halfphysics.errors import InputError
from halfphysics.render import outlines
from halfphysics.render.clothes import dressed
from halfphysics.render.ghost import faded
from halfphysics.render.look import (
    FURNITURE,
    GHOST,
    GHOST_ALPHA,
    GLASS_ALPHA,
    GRID_WIDTH,
    LIGHT,
    OBJECTS,
    PEOPLE,
    WALL,
    Color,
    Theme,
)
from halfphysics.render.rasterizer import Camera, Surface
from halfphysics.render.skin_bands import SkinPressures, banded

if TYPE_CHECKING:
    from halfphysics.results.dents import Dent
    from halfphysics.results.result import PersonResult, Result

Array = NDArray[np.float64]

# A static item this tall or wide [m] is part of the building, a smaller one is furniture.
_WALL_HEIGHT, _WALL_WIDTH = 1.9, 3.0
# A plane is drawn this far beyond the story [m]; its outer part fades out.
_PLANE_MARGIN = 7.0
# A ghost is drawn only where it is this far in front of what is behind it [m]: a ghost a little
# nearer to the camera than the body would paint all of it blue.
_GHOST_BIAS = 0.05
#: Edges of scene meshes that bend by more stay sharp [degrees].
CREASE = 50.0


def _crease(shape: Any) -> float:
    from halfphysics.geometry.shapes import Capsule, Sphere

    return 180.0 if isinstance(shape, Sphere | Capsule) else CREASE


def _unpressed(dent: Dent) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and faces of a soft thing that nothing presses, with edges short enough to dent."""
    return dent.layer.surface, dent.faces.astype(np.int32)


class StaticColors:
    """Colours of static items: pale for the building, one per piece of furniture."""

    def __init__(self) -> None:
        self._pieces: dict[str, Color] = {}

    def of(self, name: str, size: Array) -> Color:
        """The colour of an item of `size` (3,) [m] along the world's axes."""
        if size[2] >= _WALL_HEIGHT or max(size[:2]) >= _WALL_WIDTH:
            return WALL
        piece = name.split("_")[0]  # "table" and "table_leg_1" are one piece of furniture
        return self._pieces.setdefault(piece, FURNITURE[len(self._pieces) % len(FURNITURE)])


@dataclass(frozen=True, kw_only=True)
class Item:
    """A mesh of the scene, in its own frame, with its pose over time.

    Attributes:
        surface: Vertices in the local frame [m]; of a soft item, where nothing presses it.
        position, quaternion: World pose per frame, (T, 3) and (T, 4); one row for a static item.
        dent: How its vertices give in every frame; None: it is hard, or nothing presses it.
    """

    surface: Surface
    position: Array
    quaternion: Array
    dent: Dent | None = None

    @property
    def unpressed(self) -> Array:
        """The vertices in the world (V, 3) [m] at first, where nothing presses them."""
        result: Array = rot.rotate(self.quaternion[0], self.surface.vertices) + self.position[0]
        return result

    def at(self, frame: int) -> Surface:
        """The surface in the world at a frame."""
        k = min(frame, len(self.position) - 1)
        local = self.surface.vertices if self.dent is None else self.dent.at(frame)
        world = rot.rotate(self.quaternion[k], local) + self.position[k]
        return replace(self.surface, vertices=world)


def _plane_axes(normal: Array) -> Array:
    """Rows: two directions in the plane (world x and y for a floor) and the normal."""
    helper = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = helper - normal * (helper @ normal)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first), normal])


def _plane_surface(static: Any, middle: Array, radius: float, theme: Theme) -> Surface:
    """A square of the plane around the middle of the story that fades out, world frame."""
    quaternion = np.asarray(static.quaternion, dtype=np.float64)
    normal = rot.rotate(quaternion, np.asarray(static.shape.normal, dtype=np.float64))
    normal = normal / np.linalg.norm(normal)
    offset = float(static.shape.offset) + float(normal @ np.asarray(static.position))
    axes = _plane_axes(normal)
    centre = middle - normal * (normal @ middle - offset)
    reach = radius + _PLANE_MARGIN
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * reach
    level = normal[2] > 0.95
    return Surface(
        vertices=centre + corners @ axes[:2],
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        color=theme.ground if level else WALL,
        cull="back",  # a plane is not drawn from below or behind, where it would hide the story
        casts=False,
        rim=0.0,
        fade=(radius + 1.0, reach) if level else None,
    )


def _beyond(static: Any, square: Array, dent: Dent, surface: Surface) -> Surface | None:
    """The flat rest of a plane around the mesh that dents, in the static's frame.

    A plane dents within the square of its mesh, about its own origin; the story may be elsewhere.
    None: the mesh has all of `square` (4, 3), in the world [m], in it.
    """
    corners, _ = static.shape.triangles()
    sides = corners[1] - corners[0], corners[2] - corners[1]
    axes = np.array([side / np.linalg.norm(side) for side in sides])
    position = np.asarray(static.position, dtype=np.float64)
    place = rot.rotate(rot.conjugate(np.asarray(static.quaternion)), square - position)
    inner, outer = ((points @ axes.T) for points in (dent.layer.surface, place))
    (left, front), (right, back) = inner.min(axis=0), inner.max(axis=0)
    low, high = np.minimum(inner.min(0), outer.min(0)), np.maximum(inner.max(0), outer.max(0))
    around = [
        (low[0], low[1], left, high[1]),
        (right, low[1], high[0], high[1]),
        (left, low[1], right, front),
        (left, back, right, high[1]),
    ]
    wide = [(a, b, c, d) for a, b, c, d in around if c - a > 1e-9 and d - b > 1e-9]
    if not wide:
        return None
    flat = np.array([[(a, b), (c, b), (c, d), (a, d)] for a, b, c, d in wide]).reshape(-1, 2)
    normal = np.asarray(static.shape.normal, dtype=np.float64)
    faces = np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(len(wide))[:, None, None]
    return replace(
        surface,
        vertices=flat @ axes + static.shape.offset * normal,
        faces=faces.reshape(-1, 3).astype(np.int32),
    )


class Drawing:
    """The meshes of a result, ready to be drawn at any frame.

    Names are paths: `static/<name>`, `object/<name>`, `person/<k>`, `ghost/<k>`.

    Args:
        result: The result to draw.
        theme: The surroundings.

    Attributes:
        result, theme: As given.
        statics, objects: Name -> `Item`.
        middle: Centre of the story's bounding box (people and objects, all frames) [m].
        radius: Half of its largest horizontal extent [m].
    """

    def __init__(self, result: Result, theme: Theme = LIGHT) -> None:
        self.result, self.theme = result, theme
        # A moment, which is no result, has no dents.
        self._dents: Mapping[str, Dent] = getattr(result, "dents", {})
        low, high = self._extent()
        self.middle: Array = 0.5 * (low + high)
        self.radius = float(0.5 * max(high[0] - low[0], high[1] - low[1], 1.0))
        self._beyond: dict[str, Surface] = {}
        self.statics: Mapping[str, Item] = MappingProxyType(self._build_statics())
        self.objects: Mapping[str, Item] = MappingProxyType(self._build_objects())

    def in_theme(self, theme: Theme) -> Drawing:
        """The same drawing with other surroundings."""
        return self if theme is self.theme else Drawing(self.result, theme)

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.result.motion)

    def _extent(self) -> tuple[Array, Array]:
        points = [np.asarray(track.position) for track in self.result.objects.values()]
        for person in self.result.people:
            points += [person.body.joints(m)[:, 0] for m in (person.motion, person.recorded)]
        if not points:  # a scene alone
            places = [np.asarray(s.position) for s in self.result.scene.statics.values()]
            points = [np.array([*places, np.zeros(3)])]
        stacked = np.concatenate(points)
        return stacked.min(axis=0), stacked.max(axis=0)

    def _build_statics(self) -> dict[str, Item]:
        from halfphysics.geometry.shapes import Plane

        items: dict[str, Item] = {}
        colors = StaticColors()
        for name, static in self.result.scene.statics.items():
            dent = self._dents.get(name)
            pose = (
                np.asarray(static.position, dtype=np.float64).reshape(1, 3),
                np.asarray(static.quaternion, dtype=np.float64).reshape(1, 4),
            )
            if isinstance(static.shape, Plane):
                surface = _plane_surface(static, self.middle, self.radius, self.theme)
                if dent is None:
                    pose = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
                else:
                    rest = _beyond(static, surface.vertices, dent, surface)
                    if rest is not None:
                        self._beyond[f"static/{name}"] = rest
                    vertices, faces = _unpressed(dent)
                    surface = replace(surface, vertices=vertices, faces=faces, crease=180.0)
            else:
                vertices, faces = static.mesh() if dent is None else _unpressed(dent)
                size = np.ptp(rot.rotate(pose[1][0], vertices), axis=0)
                surface = Surface(
                    vertices=vertices,
                    faces=faces,
                    color=colors.of(name, size),
                    crease=_crease(static.shape),
                )
            items[f"static/{name}"] = Item(
                surface=surface, position=pose[0], quaternion=pose[1], dent=dent
            )
        return items

    def _build_objects(self) -> dict[str, Item]:
        items = {}
        for k, (name, item) in enumerate(self.result.scene.objects.items()):
            track = self.result.objects[name]
            # Draw the original mesh, not the convex hull used for contact.
            vertices, faces = item.mesh() if item.visual is None else item.visual.triangles()
            dent = self._dents.get(name)
            if dent is not None:
                vertices, faces = _unpressed(dent)
            items[f"object/{name}"] = Item(
                surface=Surface(
                    vertices=vertices,
                    faces=faces,
                    color=OBJECTS[k % len(OBJECTS)],
                    crease=_crease(item.shape),
                ),
                position=np.asarray(track.position, dtype=np.float64),
                quaternion=np.asarray(track.quaternion, dtype=np.float64),
                dent=dent,
            )
        for k, jointed in enumerate(self.result.scene.articulated.values()):
            for link, name in zip(jointed.links, jointed.link_names, strict=True):
                vertices, faces = link.mesh()
                if not len(faces) or name not in self.result.objects:
                    continue
                track = self.result.objects[name]
                color = OBJECTS[(len(items) + k) % len(OBJECTS)]
                items[f"object/{name}"] = Item(
                    surface=Surface(vertices=vertices, faces=faces, color=color, crease=CREASE),
                    position=np.asarray(track.position, dtype=np.float64),
                    quaternion=np.asarray(track.quaternion, dtype=np.float64),
                )
        return items

    def check_frame(self, frame: int) -> int:
        """`frame` as an index from 0; negative ones count from the end.

        Raises:
            InputError: There is no such frame.
        """
        total = len(self)
        if not is_whole(frame, plain=False):
            raise InputError(f"frame: found {frame!r}, expected a whole number")
        if not -total <= frame < total:
            raise InputError(
                f"frame: found {frame}, but the result has {total} frames (0 to {total - 1})"
            )
        return int(frame) % total

    def skin(self, index: int, ghost: bool) -> Surface:
        """The surface of person `index`, or its ghost; vertices are the body's rest vertices."""
        person: PersonResult = self.result.people[index]
        body = person.body
        if ghost:
            return Surface(
                vertices=body.rest_vertices,
                faces=body.faces,
                color=GHOST,
                alpha=GHOST_ALPHA,
                crease=180.0,
                rim=0.55,
                bias=_GHOST_BIAS,
                casts=False,
                receives=False,
            )
        color = PEOPLE[index % len(PEOPLE)]
        return Surface(vertices=body.rest_vertices, faces=body.faces, color=color, crease=180.0)

    def story(self, frame: int, *, ghost: bool = True) -> dict[str, Surface]:
        """People, ghosts and objects at a frame, world frame: all that must be visible."""
        surfaces = {name: item.at(frame) for name, item in self.objects.items()}
        for k, person in enumerate(self.result.people):
            poses = [("person", person.motion)]
            if ghost:
                poses.append(("ghost", person.recorded))
            for kind, motion in poses:
                vertices = person.body.vertices(motion, frames=[frame])[0]
                skin = self.skin(k, kind == "ghost")
                surfaces[f"{kind}/{k}"] = replace(skin, vertices=vertices)
        return surfaces

    def moving(
        self, frame: int, *, ghost: bool = True, pressures: SkinPressures | None = None
    ) -> list[Surface]:
        """The story as pictures show it: people in clothes, ghosts where they are apart from them.

        Args:
            frame: Index, 0 to T-1.
            ghost: Include the reference.
            pressures: Colour people by these.
        """
        story = self.story(frame, ghost=ghost)
        shown = [surface for name, surface in story.items() if name.startswith("object/")]
        ghosts = []
        for k, person in enumerate(self.result.people):
            skin = story[f"person/{k}"]
            for piece in dressed(person.body, k):
                surface = replace(
                    skin,
                    vertices=piece.cut.of(skin.vertices),
                    faces=piece.cut.faces,
                    color=piece.color,
                )
                if pressures is None:
                    shown.append(surface)
                else:
                    values = piece.cut.of(pressures.values[k][frame].astype(np.float64))
                    shown += banded(surface, values, pressures.end)
            if ghost:
                blue = story[f"ghost/{k}"]
                apart = np.linalg.norm(blue.vertices - skin.vertices, axis=1)
                ghosts += faded(blue, apart)
        return shown + ghosts

    def edges(self, camera: Camera, height: int, frame: int = 0) -> list[Surface]:
        """Edges of the statics, and the ground's lines, in a picture of this height [pixels].

        Args:
            camera: The picture's.
            height: The picture's.
            frame: Those of soft things are where they are in this frame.
        """
        strips = [
            outlines.drawn(segments, outlines.shade(color, self.theme), camera, height)
            for color, segments in self._edges.items()
        ]
        for item, border in self._borders:
            lines = border.at(item.at(frame).vertices)
            color = outlines.shade(item.surface.color, self.theme)
            strips.append(outlines.drawn(lines, color, camera, height))
        for item in self.statics.values():
            surface = item.surface
            if surface.fade is None:
                continue
            ground = float(item.unpressed[0, 2])
            if camera.position[2] > ground:
                lines = outlines.squares(self.middle, surface.fade[1], ground)
                width, line = GRID_WIDTH, self.theme.line
                strips.append(
                    outlines.drawn(lines, line, camera, height, width=width, fade=surface.fade)
                )
        return [strip for strip in strips if strip is not None]

    @cached_property
    def _borders(self) -> list[tuple[Item, outlines.Border]]:
        """The soft statics that dent, with their edges."""
        return [
            (item, outlines.border(item.surface))
            for item in self.statics.values()
            if item.dent is not None and item.surface.cull != "back"
        ]

    @cached_property
    def _edges(self) -> dict[Color, Array]:
        """Edges of the other statics of each colour, world frame (E, 2, 3) [m]."""
        found: dict[Color, list[Array]] = {}
        for item in self.statics.values():
            if item.surface.cull != "back" and item.dent is None:  # a plane has no edges
                found.setdefault(item.surface.color, []).append(outlines.edges(item.at(0)))
        return {color: np.concatenate(parts) for color, parts in found.items()}

    def still(self, faint: Collection[str] = (), frame: int = 0) -> dict[str, Surface]:
        """Static items, world frame; those named in `faint` as thin glass.

        Args:
            faint: Names of statics, `static/<name>`.
            frame: Soft ones are dented as in this frame.
        """
        return {name: self._glass(name, faint, frame) for name in self.statics}

    def dented(self, frame: int, faint: Collection[str] = ()) -> dict[str, Surface]:
        """As `still`, of a frame, only the statics that differ from frame to frame."""
        soft = [name for name, item in self.statics.items() if item.dent is not None]
        return {name: self._glass(name, faint, frame) for name in soft}

    def _glass(self, name: str, faint: Collection[str], frame: int) -> Surface:
        item = self.statics[name]
        surface = item.at(frame)
        if name in self._beyond:
            rest = self._beyond[name]
            flat = rot.rotate(item.quaternion[0], rest.vertices) + item.position[0]
            surface = replace(
                surface,
                vertices=np.concatenate([surface.vertices, flat]),
                faces=np.concatenate([surface.faces, rest.faces + len(surface.vertices)]),
            )
        # What dents is part of the story, and its dent would not show in glass.
        if name in faint and self.statics[name].dent is None:
            surface = replace(surface, alpha=GLASS_ALPHA, rim=0.12, casts=False)
        return surface

    def surfaces(
        self, frame: int, *, ghost: bool = True, faint: Collection[str] = ()
    ) -> dict[str, Surface]:
        """All surfaces at a frame, world frame.

        Args:
            frame: Index, 0 to T-1.
            ghost: Include the reference.
            faint: Names of statics to draw as thin glass, because they hide the story.
        """
        return self.still(faint, frame) | self.story(frame, ghost=ghost)
