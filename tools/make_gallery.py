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

from gallery_shots import SHOTS

import halfphysics as hp
from halfphysics import scenarios
from halfphysics.strip import strip_png

DOCS = Path(__file__).resolve().parent.parent / "docs"
PICTURES = DOCS / "pictures"
SIZE, _SAMPLES, _COLORS = (240, 240), 3, 128

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
        lines.append(f"| `--{flag}` | {_said(default)} | {meanings.get(option, '')} |")
    lines += ["", f"`halfphysics scenario {name} --page {name}.html`", ""]
    return "\n".join(lines)


def _said(default: object) -> str:
    """A default as it is typed on the command line."""
    if isinstance(default, tuple):
        return " ".join(map(str, default))
    return str(default)


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
        strip_png(
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


def main(arguments: list[str]) -> None:
    """Draws and writes what is asked for; without an argument, everything."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="SCENARIO", help="pictures of these alone")
    parser.add_argument("--text", action="store_true", help="docs/scenarios.md alone")
    chosen = parser.parse_args(arguments)
    unknown = set(chosen.names) - set(scenarios.names())
    if unknown:
        parser.error(f"no scenario {', '.join(sorted(unknown))}")
    if not chosen.text:
        PICTURES.mkdir(exist_ok=True)
        for name in chosen.names or scenarios.names():
            path = draw(name)
            print(
                f"{path.relative_to(DOCS.parent)}: {path.stat().st_size / 1000:.0f} kB", flush=True
            )
    if not chosen.names:
        (DOCS / "scenarios.md").write_text(markdown(), encoding="utf-8")
        print("docs/scenarios.md")


if __name__ == "__main__":
    main(sys.argv[1:])
