"""Draws the pictures of soft things in docs/: what dents, and pressure maps.

    python tools/make_soft_pictures.py             # everything, ten minutes on one core
    python tools/make_soft_pictures.py soft-sit    # some of them

Everything is computed anew: a scenario that changes changes its pictures.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image
from side_by_side import save_side_by_side

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.render.film.filming import workers
from halfphysics.render.look import LIGHT
from halfphysics.render.pressure_pictures import picture
from halfphysics.render.rasterizer import Camera, Look, render
from halfphysics.render.result_meshes import Drawing
from halfphysics.render.skin_bands import SkinPressures
from halfphysics.render.skin_pictures import save_skin_pressure
from halfphysics.results.pressure_maps import pressure_map

DOCS = Path(__file__).resolve().parent.parent / "docs"
#: Scenario -> its options, where something soft is not the default.
OPTIONS = {"sit_on_sofa": {"soft": "sofa"}, "stretch_on_bed": {"soft": "mattress"}}
#: The film: scenario, where the camera looks, where it stands [m], first and last moment [s].
CLIPS = (
    ("sit_on_sofa", (-0.15, 0.0, 0.8), (2.2, -2.4, 1.4), (0.7, 3.7)),
    ("stretch_on_bed", (0.0, 0.0, 0.45), (2.8, -2.7, 2.6), (0.0, 3.0)),
    ("jump_on_bed", (0.0, 0.0, 1.1), (3.2, -3.0, 1.9), (0.8, 3.8)),
    ("ball_on_cushion", (0.3, 0.0, 0.85), (2.4, -2.1, 1.4), (0.2, 3.0)),
    ("squeeze_pillow", (0.3, 0.0, 1.0), (2.1, -1.9, 1.5), (0.4, 2.8)),
)
# Of the film: size of a clip [pixels], pictures, pictures per second, quality [%].
_CLIP, _PICTURES, _FPS, _QUALITY = (230, 300), 45, 12, 72
_STILL = (420, 330)


@cache
def play(name: str) -> hp.Result:
    """The result of a scenario on something soft."""
    story = scenarios.load(name, **OPTIONS.get(name, {}))
    return hp.simulate(story.motion, story.scene, body=story.body, settings=story.settings)


def shot(
    result: hp.Result,
    drawing: Drawing,
    frame: int,
    camera: Camera,
    size: tuple[int, int],
    pressures: SkinPressures | None = None,
) -> np.ndarray:
    """A picture of a frame, without the reference."""
    shown = [
        *drawing.still(frame=frame).values(),
        *drawing.moving(frame, ghost=False, pressures=pressures),
        *drawing.edges(camera, size[1], frame),
    ]
    look = Look.of(LIGHT).aimed(camera, drawing.middle)
    return render(shown, camera, size, look=look, threads=workers(None))


def camera_of(clip: tuple) -> Camera:
    """The camera of a clip."""
    return Camera(target=np.array(clip[1]), position=np.array(clip[2]), fov=34.0)


def film() -> Path:
    """The stories beside each other: an animated WebP."""
    columns = []
    for clip in CLIPS:
        result, camera = play(clip[0]), camera_of(clip)
        drawing = Drawing(result)
        times = np.linspace(*clip[3], _PICTURES)
        frames = np.minimum(np.round(times * result.fps).astype(int), len(result) - 1)
        columns.append([shot(result, drawing, int(f), camera, _CLIP) for f in frames])
    path = DOCS / "soft.webp"
    save_side_by_side(columns, path, fps=_FPS, quality=_QUALITY)
    return path


def stills() -> Path:
    """What is left of a ball, of hands and of who sat: dents, looked at closely."""
    tiles = []
    for name, target, position, time in (
        ("sit_on_sofa", (-0.3, 0.0, 0.5), (1.2, -1.4, 0.9), 4.4),
        ("ball_on_cushion", (0.5, 0.0, 0.24), (1.15, -0.9, 0.75), 0.43),
        ("squeeze_pillow", (0.3, 0.0, 0.95), (1.5, -1.3, 1.2), 1.6),
    ):
        result = play(name)
        camera = Camera(target=np.array(target), position=np.array(position), fov=34.0)
        tiles.append(shot(result, Drawing(result), round(time * result.fps), camera, _STILL))
    path = DOCS / "soft-dents.webp"
    Image.fromarray(np.concatenate(tiles, axis=1)).save(path, quality=88, method=6)
    return path


def bed_map() -> Path:
    """The pressure map of the mattress, and the same pressure on who lies there."""
    result = play("stretch_on_bed")
    made = pressure_map(result, "mattress")
    Image.fromarray(picture(made, -1)).quantize(128).save(DOCS / "pressure-bed.png", optimize=True)
    return DOCS / "pressure-bed.png"


def seat_map() -> Path:
    """The pressure map of the sofa's seat."""
    made = pressure_map(play("sit_on_sofa"), "seat")
    Image.fromarray(picture(made, -1)).quantize(128).save(DOCS / "pressure-seat.png", optimize=True)
    return DOCS / "pressure-seat.png"


def skin_map() -> Path:
    """Pressure on the skin of who lies on a bed."""
    path = save_skin_pressure(play("stretch_on_bed"), DOCS / "pressure-skin.png", frame=-1)
    Image.open(path).quantize(128).save(path, optimize=True)
    return path


#: Name of a picture -> what draws it.
PICTURES: dict[str, Callable[[], Path]] = {
    "pressure-bed": bed_map,
    "pressure-seat": seat_map,
    "pressure-skin": skin_map,
    "soft-dents": stills,
    "soft": film,
}


def main(arguments: list[str]) -> None:
    """Draws what is asked for; without an argument, everything."""
    unknown = set(arguments) - set(PICTURES)
    if unknown:
        raise SystemExit(
            f"no picture {', '.join(sorted(unknown))}; there are {', '.join(PICTURES)}"
        )
    for name in arguments or PICTURES:
        path = PICTURES[name]()
        print(f"{path.relative_to(DOCS.parent)}: {path.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
