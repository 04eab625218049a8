"""Does the same happen wherever it happens? People at statics, simulated again elsewhere.

Each case is played as it is, beside that by a nanometre, turned by a radian about the vertical,
moved by 100 m, and mirrored. Every joint of the person is compared as seen from the scene: over the
first second in which something is touched, and over the clip.

    PYTHONPATH=src:tests python -m campaigns.invariance [--only NAME ...] [--contact skin]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

import halfphysics as hp
from halfphysics.base import rotations as rot
from halfphysics.body.body import Body
from halfphysics.geometry.shapes import Box, Mesh, Plane
from halfphysics.motion.motion import Motion
from halfphysics.motion.skeleton import MIRRORED
from halfphysics.settings import AS_IT_IS, Settings
from support.people import along_x

#: Scenarios of one person among statics alone: nothing tumbles in them.
SCENARIOS = (
    "climb_onto_bed",
    "crawl_under_table",
    "leg_through_table",
    "sit_on_bed",
    "sit_on_sofa",
    "step_back_onto_cabinet",
    "stretch_on_bed",
    "walk_into_wall",
)
#: Limits of the largest difference of a joint [m]: over a second from the first contact, and over
#: the clip.
FIRST, WHOLE = 1e-6, 1e-3


@dataclass(frozen=True)
class Place:
    """Where a scene is put: mirrored at y = 0 first, then turned about z [rad], then moved [m].

    `beside` is by how much the person alone is moved [m].
    """

    mirror: bool = False
    yaw: float = 0.0
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    beside: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> np.ndarray:
        """From the scene as it is to where it is put, without the shift (3, 3)."""
        turn = rot.to_matrix(rot.exp([0.0, 0.0, self.yaw]))
        return turn @ np.diag([1.0, -1.0 if self.mirror else 1.0, 1.0])


#: Name -> place.
PLACES = {
    "beside": Place(beside=(1e-9, 1e-9, 0.0)),
    "yaw": Place(yaw=1.0),
    "100 m": Place(shift=(100.0, 50.0, 0.0)),
    "mirror": Place(mirror=True),
}


@dataclass(frozen=True)
class Case:
    """A motion of the default body among statics."""

    motion: Motion
    scene: hp.Scene
    settings: Settings


def cases(contact: str) -> Iterator[tuple[str, Case]]:
    """Name and case: a wall, a jamb, and the scenarios."""
    pressed = Settings(substeps=8, contact=contact, **AS_IT_IS)
    glide = along_x(1.5, 47, start=-0.1)
    for name, wide in (("wall", 6.0), ("jamb", 0.1)):
        scene = hp.Scene()
        at = (0.5, 0.0 if name == "wall" else 0.15, 0.0)
        scene.add_static(name, Box((0.01 if name == "wall" else 0.1, wide, 6.0)), position=at)
        yield name, Case(glide, scene, pressed)
    for name in SCENARIOS:
        told = hp.scenarios.load(name, body=Body.default())
        yield name, Case(told.motions[0], told.scene, Settings(substeps=8, contact=contact))


def put(case: Case, place: Place, body: Body) -> Case:
    """The case at a place."""
    R = place.matrix
    scene = hp.Scene()
    for s in case.scene.statics.values():
        position = R @ s.position + place.shift
        shape, quaternion = s.shape, s.quaternion
        if isinstance(shape, Plane):
            shape = replace(shape, normal=tuple(R @ np.asarray(shape.normal)))
        else:
            if place.mirror and isinstance(shape, Mesh):
                shape = Mesh(shape.vertices * [1.0, -1.0, 1.0], shape.faces[:, ::-1])
            flip = np.diag([1.0, -1.0 if place.mirror else 1.0, 1.0])
            quaternion = rot.from_matrix(R @ rot.to_matrix(quaternion) @ flip)
        scene.add_static(
            s.name,
            shape,
            position=np.zeros(3) if isinstance(shape, Plane) else position,
            quaternion=quaternion,
            friction=s.friction,
            restitution=s.restitution,
        )
    return replace(case, motion=put_motion(case.motion, place, body), scene=scene)


def put_motion(motion: Motion, place: Place, body: Body) -> Motion:
    """The motion at a place; mirrored, left and right change places too."""
    R = place.matrix
    pelvis = motion.axes @ np.asarray(body.rest_joints)[0]
    rotations = motion.rotations
    root = rot.to_matrix(rot.exp(rotations[:, 0]))
    if place.mirror:
        # x points left at rest: a rotation about (x, y, z) becomes one about (x, -y, -z).
        rotations = rotations[:, MIRRORED] * [1.0, -1.0, -1.0]
        root = root @ np.diag([-1.0, 1.0, 1.0])
    rotations = np.array(rotations)
    rotations[:, 0] = rot.log(rot.from_matrix(R @ root))
    path = (motion.translation + pelvis) @ R.T - pelvis + place.shift + place.beside
    return motion.with_frames(path, rotations)


def joints(case: Case, place: Place, body: Body) -> tuple[np.ndarray, int]:
    """Joints (T, 55, 3) [m], seen from the scene as it is, and the first frame with contact."""
    at = put(case, place, body)
    result = hp.simulate(at.motion, at.scene, body=body, settings=at.settings)
    seen = (body.joints(result.motion) - place.shift - place.beside) @ place.matrix
    touched = result.contacts.frame
    first = int(touched.min()) if len(touched) else len(seen) - 1
    return (seen[:, MIRRORED] if place.mirror else seen), first


def differences(case: Case, body: Body) -> dict[str, tuple[float, float]]:
    """Place -> largest difference of a joint [m]: over a second from the first contact, whole."""
    here, first = joints(case, Place(), body)
    out = {}
    for name, place in PLACES.items():
        off = np.abs(joints(case, place, body)[0] - here).max(axis=(1, 2))
        second = off[: first + round(case.motion.fps) + 1]
        out[name] = (float(second.max()), float(off.max()))
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--only", nargs="*", default=None)
    parser.add_argument("--contact", choices=("skin", "parts"), default="skin")
    chosen = parser.parse_args()
    body = Body.default()
    print(f"{'case':24s}" + "".join(f"{name:>20s}" for name in PLACES))
    kept = [0, 0]
    for name, case in cases(chosen.contact):
        if chosen.only and name not in chosen.only:
            continue
        found = differences(case, body)
        cells = [f"{second:9.1e} {whole:9.1e}" for second, whole in found.values()]
        print(f"{name:24s}" + "".join(f"{cell:>20s}" for cell in cells), flush=True)
        kept[0] += sum(s <= FIRST and w <= WHOLE for s, w in found.values())
        kept[1] += len(found)
    print(f"{kept[0]} of {kept[1]} within {FIRST:g} m for a second and {WHOLE:g} m over the clip")


if __name__ == "__main__":
    main()
