"""Objects to press a body against, as primitives, closed meshes, one merged mesh or open sheets.

World frame: z up. A `Piece` is one convex object; furniture is a list of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from halfphysics.base import rotations as rot
from halfphysics.geometry.shapes import Box, Capsule, Cylinder, Mesh, Plane
from halfphysics.scene.scene import Scene

#: primitives; a closed mesh each; all in one mesh; open sheets: only the pressed faces.
KINDS = ("primitives", "meshes", "merged", "sheets")
#: Longest edge of a mesh [m].
EDGE = 0.35
#: Half the side of the box that represents a floor in a mesh, and its thickness [m].
FLOOR, THICK = 2.0, 0.2


@dataclass(frozen=True)
class Piece:
    """A convex object at a fixed place.

    `shape`: a primitive, or (vertices, faces) of a convex mesh. `open_faces`: outward normals, in
    its own frame, of the faces that remain as a sheet; empty: all but the end caps.
    """

    name: str
    shape: object
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    open_faces: tuple[tuple[float, float, float], ...] = ()

    def moved(self, way):
        """The same piece at another place."""
        return replace(self, position=tuple(np.asarray(self.position) + way))

    def triangles(self, sheet=False):
        """Vertices (V, 3) and faces (F, 3) in the world, long edges cut."""
        import trimesh

        turn = rot.to_matrix(np.asarray(self.quaternion))
        shape = self.shape
        if isinstance(shape, Plane):  # its top at the plane, around the origin
            normal = turn @ np.asarray(shape.normal)
            turn = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], normal)[:3, :3]
            at = np.asarray(self.position) + (shape.offset - 0.5 * THICK) * normal
            vertices, faces = Box((2 * FLOOR, 2 * FLOOR, THICK)).triangles()
            wanted = ((0.0, 0.0, 1.0),)
        else:
            vertices, faces = shape if isinstance(shape, tuple) else shape.triangles()
            at, wanted = self.position, self.open_faces
        mesh = trimesh.Trimesh(vertices, faces, process=False)
        if sheet:
            normals = mesh.face_normals
            if wanted:
                kept = (normals @ np.asarray(wanted).T > 1.0 - 1e-6).any(axis=1)
            else:
                kept = np.abs(normals[:, 2]) < 1.0 - 1e-6
            mesh.update_faces(kept)
        v, f = np.asarray(mesh.vertices), np.asarray(mesh.faces)
        # All triangles are cut alike, so that a closed mesh stays closed.
        while not isinstance(shape, Plane) and _longest(v, f) > EDGE:
            v, f = trimesh.remesh.subdivide(v, f)
        return v @ turn.T + at, f


def _longest(vertices, faces):
    corners = vertices[faces]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max()


def scene_of(pieces, kind):
    """A scene of `pieces` as one of `KINDS`."""
    scene = Scene()
    if kind == "primitives":
        for p in pieces:
            shape = Mesh(*p.shape) if isinstance(p.shape, tuple) else p.shape
            scene.add_static(p.name, shape, position=p.position, quaternion=p.quaternion)
        return scene
    made = [p.triangles(sheet=kind == "sheets") for p in pieces]
    if kind in ("meshes", "sheets"):
        for p, (v, f) in zip(pieces, made, strict=True):
            scene.add_static(p.name, Mesh(v, f))
        return scene
    first = np.cumsum([0, *(len(v) for v, _ in made)])
    faces = [f + k for (_, f), k in zip(made, first[:-1], strict=True)]
    scene.add_static("all", Mesh(np.concatenate([v for v, _ in made]), np.concatenate(faces)))
    return scene


def box(name, low, high, *faces):
    """A box between two corners; `faces`: the faces that remain as a sheet, such as "+z"."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    normals = tuple(_axis(f) for f in faces) or tuple(_axis(f) for f in ("+z", "+x", "-x"))
    return Piece(name, Box(tuple(high - low)), tuple(0.5 * (low + high)), open_faces=normals)


def _axis(face):
    out = np.zeros(3)
    out["xyz".index(face[1])] = 1.0 if face[0] == "+" else -1.0
    return tuple(out)


def floor(z):
    """The ground."""
    return Piece("floor", Plane((0.0, 0.0, 1.0), float(z)))


def along(direction):
    """Quaternion that turns z into `direction`."""
    import trimesh

    turn = trimesh.geometry.align_vectors([0.0, 0.0, 1.0], np.asarray(direction, float))
    return tuple(rot.from_matrix(turn[:3, :3]))


def pole(name, at, direction, diameter, length=1.6, round_ends=False):
    """A rod through a point."""
    radius = 0.5 * diameter
    shape = (Capsule if round_ends else Cylinder)(radius, length)
    return Piece(name, shape, tuple(at), along(direction))


def wedge(name, at, ridge, toward, degrees, height=0.3, length=1.0):
    """A roof of this angle whose ridge goes through `at` along `ridge` and points `toward`."""
    half = height * np.tan(0.5 * np.radians(degrees))
    corners = [[0.0, 0.0], [-half, -height], [half, -height]]
    vertices = np.array([[s * 0.5 * length, y, z] for s in (-1.0, 1.0) for y, z in corners])
    faces = [[0, 2, 1], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
    slope = np.array([height, half]) / np.hypot(height, half)
    sides = tuple((0.0, s * slope[0], slope[1]) for s in (-1.0, 1.0))
    return Piece(name, (vertices, np.array(faces)), tuple(at), _frame(ridge, toward), sides)


def corner(name, at, toward, size=0.5):
    """A box whose corner is at a point and points `toward`."""
    import trimesh

    diagonal = np.ones(3) / np.sqrt(3.0)
    turn = trimesh.geometry.align_vectors(diagonal, np.asarray(toward, float))[:3, :3]
    middle = np.asarray(at) - turn @ (0.5 * size * np.ones(3))
    faces = tuple(_axis(f) for f in ("+x", "+y", "+z"))
    return Piece(name, Box((size,) * 3), tuple(middle), tuple(rot.from_matrix(turn)), faces)


def board(name, at, edge, toward, thick=0.02, depth=0.4, length=1.2):
    """A board whose edge goes through `at` along `edge` and points `toward`."""
    turn = rot.to_matrix(np.asarray(_frame(edge, toward)))
    middle = np.asarray(at) - turn @ np.array([0.0, 0.0, 0.5 * depth])
    shape = Box((length, thick, depth))
    return Piece(name, shape, tuple(middle), tuple(rot.from_matrix(turn)), ((0.0, 1.0, 0.0),))


def _frame(x, z):
    """Quaternion of a frame whose x axis is `x` and whose z axis is nearest to `z`."""
    x = np.asarray(x, float) / np.linalg.norm(x)
    z = np.asarray(z, float) - x * (x @ np.asarray(z, float))
    z /= np.linalg.norm(z)
    return tuple(rot.from_matrix(np.stack([x, np.cross(z, x), z], axis=1)))


def chair(seat, front, back, y=0.0, wide=0.45, rest=0.45):
    """Seat plate at height `seat` from `front` to `back` (x), a backrest behind it, four legs."""
    half, thick, leg = 0.5 * wide, 0.04, 0.018
    out = [
        box("seat", (back, y - half, seat - thick), (front, y + half, seat), "+z", "+x"),
        box(
            "rest", (back - 0.03, y - half, seat + 0.12), (back, y + half, seat + rest), "+x", "+z"
        ),
    ]
    for i, x in enumerate((back + leg, front - leg)):
        for j, side in enumerate((y - half + leg, y + half - leg)):
            down = seat - thick - 0.12
            out.append(pole(f"leg{i}{j}", (x, side, down), (0, 0, 1), 2 * leg, 0.2, True))
    return out


def sofa(seat, front, back, y=0.0, wide=0.7, arm=0.2, rest=0.45):
    """Seat, back and arm rests, `arm` higher than the seat; low ones of boxes."""
    half = 0.5 * wide
    low = seat - 0.3
    return [
        box("seat", (back, y - half, low), (front, y + half, seat), "+z", "+x"),
        box(
            "rest",
            (back - 0.2, y - half - 0.15, low),
            (back, y + half + 0.15, seat + rest),
            "+x",
            "+z",
        ),
        box(
            "arm_left",
            (back, y + half, low),
            (front, y + half + 0.15, seat + arm),
            "+z",
            "-y",
            "+x",
        ),
        box(
            "arm_right",
            (back, y - half - 0.15, low),
            (front, y - half, seat + arm),
            "+z",
            "+y",
            "+x",
        ),
    ]


def bed(top, low, high, head=None):
    """A mattress from `low` to `high` (x, y), its top at a height; a board at the head's end."""
    out = [box("mattress", (*low, top - 0.25), (*high, top), "+z", "+x", "-x", "+y", "-y")]
    if head is not None:
        ends = sorted((head, head + np.sign(head) * 0.04))
        out.append(
            box(
                "headboard",
                (ends[0], low[1], top - 0.25),
                (ends[1], high[1], top + 0.4),
                "+x",
                "-x",
            )
        )
    return out


def table(top, front, far, left, right, thick=0.03):
    """A plate with four round legs; edges at x = front, far and y = left, right."""
    out = [
        box("plate", (front, right, top - thick), (far, left, top), "+z", "-z", "-x", "+y", "-y")
    ]
    for i, x in enumerate((front + 0.05, far - 0.05)):
        for j, y in enumerate((right + 0.05, left - 0.05)):
            out.append(pole(f"leg{i}{j}", (x, y, top - thick - 0.21), (0, 0, 1), 0.05, 0.4))
    return out
