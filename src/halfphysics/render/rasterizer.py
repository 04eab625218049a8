"""Pictures without GL or display: triangle meshes through a software z-buffer.

World z-up, metres; colours are sRGB, 0 to 1. The same meshes give the same bytes for any number
of threads.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfphysics.errors import InputError
from halfphysics.render.look import KEY, LIGHT, Theme, turned
from halfphysics.render.look import Color as Color

Array = NDArray[np.float64]

_CULL = {"none": 0, "back": 1, "front": 2}


def _vector(name: str, value: ArrayLike, length: int = 3) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (length,) or not np.isfinite(array).all():
        raise InputError(f"{name}: expected {length} finite numbers, found {value!r}")
    return array


def _number(name: str, value: float, low: float, high: float, what: str) -> float:
    if not low < value < high:  # NaN fails too
        raise InputError(f"{name}: found {value!r}, expected {what}")
    return float(value)


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A triangle mesh and its appearance.

    Attributes:
        vertices: World positions [m], shape (V, 3).
        faces: Indices into the vertices, counter-clockwise from outside, shape (F, 3).
        color: sRGB, 0 to 1.
        alpha: Opacity. Below 1 only the nearest layer of the mesh is drawn, translucent.
        crease: Edges that bend by less are smooth [degrees]; 0 gives flat faces, 180 a skin.
        cull: `"back"` drops faces turned away from the camera, `"front"` those towards it.
        casts, receives: Whether it casts and receives shadows.
        rim: Light added at grazing angles; for a translucent mesh, opacity instead.
        bias: A translucent mesh is drawn only where it is nearer than solid ones by this [m].
        checker: Second colour of a chequered surface (squares in world x and y), or None.
        checker_size: Side of a square [m].
        fade: Distances from `Look.focus` between which the surface dissolves [m], or None.
    """

    vertices: Array
    faces: NDArray[np.int32]
    color: Color = (0.8, 0.8, 0.8)
    alpha: float = 1.0
    crease: float = 0.0
    cull: str = "none"
    casts: bool = True
    receives: bool = True
    rim: float = 0.06
    bias: float = 0.0
    checker: Color | None = None
    checker_size: float = 1.0
    fade: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        faces = np.asarray(self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
            raise InputError(
                f"vertices: expected finite numbers of shape (V, 3), found shape {vertices.shape}"
            )
        if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer):
            raise InputError(
                f"faces: expected integers of shape (F, 3), found {faces.dtype} {faces.shape}"
            )
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(vertices):
            raise InputError(
                f"faces: indices {faces.min()} to {faces.max()} do not all fall among the "
                f"{len(vertices)} vertices"
            )
        if self.cull not in _CULL:
            raise InputError(f"cull: found {self.cull!r}, expected one of {', '.join(_CULL)}")
        _number("alpha", self.alpha, -1e-12, 1.0 + 1e-12, "0 to 1")
        _number("checker_size", self.checker_size, 0.0, np.inf, "a length in metres above 0")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", np.ascontiguousarray(faces, dtype=np.int32))


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A perspective camera.

    Attributes:
        position: World position of the eye [m].
        target: World point in the middle of the picture [m].
        up: Direction that is up in the picture.
        fov: Angle that the picture's height spans [degrees].
        near: Distance of the near clipping plane [m].
    """

    position: Array
    target: Array = field(default_factory=lambda: np.zeros(3))
    up: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    fov: float = 35.0
    near: float = 0.05

    def __post_init__(self) -> None:
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, _vector(name, getattr(self, name)))
        _number("fov", self.fov, 0.0, 170.0, "an angle between 0 and 170 degrees")
        _number("near", self.near, 0.0, np.inf, "a length in metres above 0")
        self.axes()

    def axes(self) -> Array:
        """Rows: the world directions of the picture's right, down and into it. Shape (3, 3)."""
        forward = self.target - self.position
        right = np.cross(forward, self.up)
        if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(forward) or not forward.any():
            raise InputError(
                f"Camera: target {self.target} is at the position {self.position} or straight "
                f"along up {self.up}; move one of them"
            )
        down = np.cross(forward, right)
        rows = np.stack([right, down, forward])
        result: Array = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        return result

    @staticmethod
    def framing(
        points: ArrayLike,
        direction: ArrayLike,
        *,
        size: tuple[int, int] = (640, 480),
        fov: float = 35.0,
        margin: float = 1.08,
        distance: float = 0.0,
        up: ArrayLike = (0.0, 0.0, 1.0),
    ) -> Camera:
        """The nearest camera with all `points` in the picture, centred.

        Args:
            points: World positions [m], shape (N, 3).
            direction: World direction from the points to the camera.
            size: Width and height of the picture (their ratio matters).
            fov: Angle of the picture's height [degrees].
            margin: Space around the points: 1.1 leaves a tenth.
            distance: Least distance from the middle of the points [m].
            up: Direction that is up in the picture.
        """
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(points) or not np.isfinite(points).all():
            raise InputError("Camera.framing: points must be finite, at least one")
        toward = _vector("direction", direction)
        toward = toward / np.linalg.norm(toward)
        up = _vector("up", up)
        right, down, _ = Camera(position=toward, up=up).axes()
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        local = (points - middle) @ np.stack([right, down, toward]).T
        tan_y = np.tan(np.radians(fov) / 2) / margin
        tans = (tan_y * size[0] / size[1], tan_y)
        # |x - c| <= tan (d - z) on both sides, for both axes: the least d has both sides tight.
        centre, needed = [], [distance]
        for axis, tan in enumerate(tans):
            a = float(np.max(local[:, axis] / tan + local[:, 2]))
            b = float(np.max(-local[:, axis] / tan + local[:, 2]))
            centre.append(tan * (a - b) / 2)
            needed.append((a + b) / 2)
        target = middle + centre[0] * right + centre[1] * down
        reach = max(*needed, float(local[:, 2].max()) + 0.1)
        return Camera(position=target + reach * toward, target=target, up=up, fov=fov)

    def table(self, size: tuple[int, int]) -> Array:
        """The 17 numbers that the native core reads, for a picture of `size` pixels."""
        width, height = size
        focal = 0.5 * height / np.tan(np.radians(self.fov) / 2)
        inner = (focal, focal, 0.5 * width, 0.5 * height, self.near)
        return np.concatenate([self.axes().ravel(), self.position, inner])


@dataclass(frozen=True, kw_only=True)
class Light:
    """A white directional light.

    Attributes:
        towards: World direction from the scene to the light.
        strength: Light added to a white surface that faces it.
        softness: Width over which the edge of a shadow blurs [m].
        wrap: 0: Lambert; 1: also lights surfaces turned away, like a bright sky.
    """

    towards: tuple[float, float, float]
    strength: float
    softness: float = 0.03
    wrap: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Look:
    """Background and light: a key light from the left, a wide one overhead, and a soft sky.

    Attributes:
        top, bottom: Background colours (sRGB), a vertical gradient.
        sky, ground: Ambient light from above and below, linear.
        lights: The lights; each casts shadows. The wide one overhead darkens surfaces near
            a contact.
        focus: World point around which surfaces with `fade` dissolve [m].
    """

    top: Color = LIGHT.top
    bottom: Color = LIGHT.horizon
    sky: Color = (0.30, 0.31, 0.33)
    ground: Color = (0.22, 0.21, 0.20)
    lights: tuple[Light, ...] = field(
        default=(
            Light(towards=KEY, strength=0.60, softness=0.07),
            Light(towards=(0.0, 0.0, 1.0), strength=0.30, softness=0.40, wrap=0.6),
        )
    )
    focus: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, theme: Theme) -> Look:
        """The look with the sky of a theme."""
        return cls(top=theme.top, bottom=theme.horizon)

    def aimed(self, camera: Camera, focus: ArrayLike) -> Look:
        """This look with `focus`, and its lights turned with the camera (they stay to its left).

        The default lights are for a camera that looks along world y.
        """
        back = -camera.axes()[2]
        towards = (float(back[0]), float(back[1]))
        lights = tuple(
            replace(light, towards=turned(light.towards, towards)) for light in self.lights
        )
        x, y, z = _vector("focus", focus)
        return replace(self, lights=lights, focus=(float(x), float(y), float(z)))


def linear(color: Color) -> Array:
    """Linear light of an sRGB colour."""
    c = np.clip(np.asarray(color, dtype=np.float64), 0.0, 1.0)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    if not (1 <= width <= 8192 and 1 <= height <= 8192):
        raise InputError(f"size: found {size}, expected width and height of 1 to 8192 pixels")
    return int(width), int(height)


def _pack(
    surfaces: Sequence[Surface],
) -> tuple[Array, NDArray[np.int32], NDArray[np.int32], Array, NDArray[np.int32]]:
    """The tables of the native core: vertices, faces, mesh of each face, styles, flags."""
    vertices = [np.zeros((0, 3)), *(s.vertices for s in surfaces)]
    first = np.cumsum([len(v) for v in vertices])
    faces = [np.zeros((0, 3), np.int32)]
    faces += [s.faces + np.int32(n) for s, n in zip(surfaces, first, strict=False)]
    owner = np.repeat(
        np.arange(len(surfaces), dtype=np.int32), [len(s.faces) for s in surfaces]
    ).astype(np.int32)
    styles, flags = np.zeros((len(surfaces), 13)), np.zeros((len(surfaces), 3), np.int32)
    for row, flag, s in zip(styles, flags, surfaces, strict=True):
        row[0:3] = linear(s.color)
        row[3:6] = linear(s.checker if s.checker is not None else s.color)
        row[6:9] = s.alpha, s.rim, 0.0 if s.checker is None else s.checker_size
        row[9] = s.bias
        row[10:12] = (0.0, 0.0) if s.fade is None else s.fade
        # A flat face must still use its own normal, at angle 0.
        row[12] = np.cos(np.radians(s.crease)) - (1e-9 if s.crease < 180.0 else 1.0)
        flag[:] = _CULL[s.cull], s.casts, s.receives
    return np.concatenate(vertices), np.concatenate(faces), owner, styles, flags


def render(
    surfaces: Sequence[Surface],
    camera: Camera,
    size: tuple[int, int] = (640, 480),
    *,
    samples: int = 2,
    look: Look | None = None,
    threads: int = 1,
) -> NDArray[np.uint8]:
    """A picture of the surfaces.

    Args:
        surfaces: Surfaces to draw; their order matters only at exactly equal depth.
        camera: The camera.
        size: Width and height [pixels].
        samples: Anti-aliasing with samples x samples points per pixel, 1 to 4.
        look: Background and lights; None is the default studio.
        threads: Worker threads; the picture does not depend on it.

    Returns:
        sRGB bytes, shape (height, width, 3).

    Raises:
        InputError: An impossible size or sample count.
    """
    from halfphysics import _render

    width, height = _checked_size(size)
    if samples not in (1, 2, 3, 4):
        raise InputError(f"samples: found {samples!r}, expected 1, 2, 3 or 4")
    if threads < 1:
        raise InputError(f"threads: found {threads!r}, expected 1 or more")
    look = look or Look()
    table = np.array([linear(look.top), linear(look.bottom), look.sky, look.ground, look.focus])
    lights = np.array(
        [[*light.towards, light.strength, light.softness, light.wrap] for light in look.lights],
        dtype=np.float64,
    ).reshape(-1, 6)
    result: NDArray[np.uint8] = _render.picture(
        *_pack(surfaces), camera.table(size), table, lights, width, height, samples, threads
    )
    return result


def visible(
    surfaces: Sequence[Surface], camera: Camera, size: tuple[int, int] = (160, 120)
) -> tuple[NDArray[np.int32], Array]:
    """The nearest surface at each pixel's centre, translucent or not.

    Returns:
        Index of the nearest surface, -1 for none, shape (height, width), and its depth along the
        viewing direction [m] (inf for none).
    """
    from halfphysics import _render

    width, height = _checked_size(size)
    result: tuple[NDArray[np.int32], Array] = _render.visible(
        *_pack(surfaces), camera.table(size), width, height
    )
    return result


def save_png(image: NDArray[np.uint8], path: str | os.PathLike[str]) -> None:
    """Writes a picture (height, width, 3) as PNG, whole or not at all.

    Raises:
        FileError: The file cannot be written.
    """
    from PIL import Image

    from halfphysics.base.atomic import atomic_write

    with atomic_write(path) as file:
        Image.fromarray(image).save(file, format="PNG")
