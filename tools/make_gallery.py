"""Draws every picture and film of the documentation, and writes docs/scenarios.md.

    python tools/make_gallery.py                  # everything, a few minutes on one core
    python tools/make_gallery.py kick_ball meet   # the pictures of these scenarios
    python tools/make_gallery.py --text           # docs/scenarios.md alone
    python tools/make_gallery.py --film           # the README's film and picture alone

A new scenario needs a line in `gallery_shots.py` and a run of this; a test says so. Everything is
drawn by the software renderer: no GPU, no display.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
from gallery_shots import CLIPS, SHOTS
from side_by_side import save_side_by_side

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.render.contact_sheet import contact_sheet_png
from halfphysics.render.film import FilmOptions
from halfphysics.render.film.filming import Shoot, workers

DOCS = Path(__file__).resolve().parent.parent / "docs"
PICTURES = DOCS / "pictures"
SIZE, _SAMPLES, _COLORS = (240, 240), 3, 128
# The README's film: height [pixels], pictures, pictures and story per second, quality [%].
_HEIGHT, _PICTURES, _FPS, _SPEED, _QUALITY = 330, 66, 15, 0.75, 75
# The README's picture [s].
_MOMENTS = (0.9, 1.9, 2.37, 2.6, 3.1, 4.3, 4.9, 5.53)

_HEAD = """\
# The built-in scenarios

Authored stories, each a motion, a scene and objects that bring each other to life. The motion in
each was made without regard for what is in the way: blue shows it where it and the body differ.

```sh
halfphysics scenario --list                       # these, in the terminal
halfphysics scenario kick_ball --page kick.html   # play one, look at it in a browser
halfphysics scenario kick_ball --mass 200 --help  # its options
```

```python
story = hp.scenarios.load("kick_ball", mass=2.0)
result = hp.simulate(story.motion, story.scene, body=story.body, settings=story.settings)
```

Every scenario also takes `body=` in Python (`meet` and `shake_hands`: `other=` too), and on the
command line every field of `hp.Settings`, such as `--stiffness 0`.
"""
_FOOT = """\
This page and its pictures are made by `python tools/make_gallery.py` from what the scenarios say
of themselves.
"""


def markdown() -> str:
    """The whole of docs/scenarios.md."""
    names = scenarios.names()
    links = " · ".join(f"[{name}](#{name})" for name in names)
    return "\n".join([_HEAD, links, "", *map(entry, names), _FOOT])


def entry(name: str) -> str:
    """What docs/scenarios.md says of one scenario."""
    said = scenarios.describe(name)
    meanings, known = scenarios.explain(name), scenarios.options(name)
    lines = [f"## {name}", "", said, "", f"![{said}](pictures/{name}.png)", ""]
    lines += ["| option | default | |", "|---|---|---|"]
    for option, default in known.items():
        if option in ("body", "other"):
            continue  # objects, not text
        flag = option.replace("_", "-")
        meaning = meanings.get(option, "").replace("None:", "none:")
        lines.append(f"| `--{flag}` | {_said(default)} | {meaning} |")
    lines += ["", f"`halfphysics scenario {name} --page {name}.html`", ""]
    return "\n".join(lines)


def _said(default: object) -> str:
    """A default as it is typed on the command line."""
    if isinstance(default, tuple):
        return " ".join(map(str, default))
    return {"False": "off", "None": "none"}.get(str(default), str(default))


def play(name: str) -> hp.Result:
    """The result of a scenario as it is."""
    story = scenarios.load(name)
    return hp.simulate(story.motion, story.scene, body=story.body, settings=story.settings)


def draw(name: str) -> Path:
    """Writes the picture strip of one scenario."""
    result, shot = play(name), SHOTS[name]
    frames, views = shot.frames(result), shot.views(result, SIZE)
    path = PICTURES / f"{name}.png"
    path.write_bytes(
        contact_sheet_png(
            result,
            frames,
            columns=len(frames),
            size=SIZE,
            samples=_SAMPLES,
            colors=_COLORS,
            views=views,
        )
    )
    return path


def film() -> Path:
    """Writes the README's film: an animated WebP, which GitHub shows where it stands.

    Parts are put beside each other as pictures: each has its own story, time and camera.
    """
    columns = []
    for clip in CLIPS:
        result = play(clip.name)
        last = (len(result) - 1) / result.fps
        times = np.minimum(clip.start + _SPEED / _FPS * np.arange(_PICTURES), last)
        options = FilmOptions(camera=(clip.camera,), size=(clip.width, _HEIGHT), text=clip.key)
        shoot = Shoot([result], options, [times * result.fps], rate=_FPS / _SPEED)
        columns.append(shoot.pictures(workers(None)))
    path = DOCS / "film.webp"
    save_side_by_side(columns, path, fps=_FPS, quality=_QUALITY)
    return path


def picture() -> Path:
    """Writes the README's picture: the story of `halfphysics demo`."""
    path = DOCS / "demo.png"
    result = play("doorway")
    frames = [round(time * result.fps) for time in _MOMENTS]
    path.write_bytes(contact_sheet_png(result, frames, 4, (240, 280), samples=_SAMPLES, colors=256))
    return path


def main(arguments: list[str]) -> None:
    """Draws and writes what is asked for; without an argument, everything."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="SCENARIO", help="pictures of these alone")
    parser.add_argument("--film", action="store_true", help="the README's film and picture alone")
    parser.add_argument("--text", action="store_true", help="docs/scenarios.md alone")
    chosen = parser.parse_args(arguments)
    unknown = set(chosen.names) - set(scenarios.names())
    if unknown:
        parser.error(f"no scenario {', '.join(sorted(unknown))}")
    everything = not (chosen.names or chosen.text or chosen.film)
    if chosen.names or everything:
        PICTURES.mkdir(exist_ok=True)
        for name in chosen.names or scenarios.names():
            _tell(draw(name))
    if chosen.film or everything:
        _tell(film())
        _tell(picture())
    if chosen.text or everything:
        path = DOCS / "scenarios.md"
        path.write_text(markdown(), encoding="utf-8")
        _tell(path)


def _tell(path: Path) -> None:
    print(f"{path.relative_to(DOCS.parent)}: {path.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
