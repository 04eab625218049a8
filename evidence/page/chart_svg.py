"""A matplotlib figure as an SVG element for the page: themed by the page's style sheet.

Matplotlib writes a file: with a style sheet, definitions that are referenced by name, and fixed
colours. In a page the names would clash and the colours could not follow the theme. So references
are replaced by what they name, and each colour of `COLOURS` by a variable of the style sheet. Text
stays text, in the page's font.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal
from xml.etree import ElementTree

import matplotlib
from matplotlib.figure import Figure

_SVG = "{http://www.w3.org/2000/svg}"
_HREF = "{http://www.w3.org/1999/xlink}href"
#: Size of all text [px]; `style.css` sets the same.
FONT = 14.0
#: Variables of the style sheet, and the colour that stands for each in a figure.
COLOURS = {
    name: f"#0000{k:02x}"
    for k, name in enumerate(
        ("ink", "soft", "hair", "paper", "s0", "s1", "s2", "s3", "s4", "s5"), start=1
    )
}
_STYLE: Any = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "evidence",  # the same bytes in every run
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same layout on every machine
    "font.size": FONT,
    "text.parse_math": False,  # a name with dollar signs is a name
    "text.color": COLOURS["ink"],
    "path.simplify_threshold": 0.5,  # [px]
    "lines.scale_dashes": False,
    "figure.constrained_layout.w_pad": 1 / 72,  # [inch]
    "figure.constrained_layout.h_pad": 3 / 72,
    "axes.autolimit_mode": "round_numbers",
    "axes.xmargin": 0,
    "axes.ymargin": 0,
    "axes.labelpad": 6,
    "xtick.major.pad": 6,
    "ytick.major.pad": 8,
    "axes.edgecolor": COLOURS["soft"],
    "axes.labelcolor": COLOURS["soft"],
    "xtick.color": COLOURS["soft"],
    "ytick.color": COLOURS["soft"],
    "grid.color": COLOURS["hair"],
    "grid.linewidth": 1,
}
#: Declarations that are the default of SVG, or that the style sheet of the page makes.
_DEFAULTS = re.compile(r"(font[-a-z]*|stroke-linejoin|stroke-linecap): [^;]*(; )?")
_NUMBER = re.compile(r"-?\d+\.\d+")


@contextmanager
def style() -> Iterator[None]:
    """Within it figures are made and written with the style of the report, whatever the user's."""
    with matplotlib.rc_context(), warnings.catch_warnings():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        # The page's font has letters that the font of the layout lacks.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def figure(width: float, height: float, layout: Literal["constrained"] | None) -> Figure:
    """An empty figure of a size in px."""
    return Figure((width / 72, height / 72), dpi=72, layout=layout)


def element(made: Figure, attributes: dict[str, str]) -> str:
    """A figure as an `svg` element; `attributes` are added to those of its size."""
    file = io.StringIO()
    nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
    made.savefig(file, format="svg", transparent=True, metadata=nothing)
    root = ElementTree.fromstring(file.getvalue())
    named = {part.get("id"): part for part in root.iter()}
    width, height = (f"{72 * size:g}" for size in made.get_size_inches())
    out = ElementTree.Element("svg", {"width": width, "height": height, **attributes})
    out.set("viewBox", f"0 0 {width} {height}")
    out.extend(_children(root, named))
    return ElementTree.tostring(out, encoding="unicode")


def _children(
    parent: ElementTree.Element, named: dict[str | None, ElementTree.Element]
) -> Iterator[ElementTree.Element]:
    """What a part draws, without groups, names and references."""
    for part in parent:
        kind = part.tag.removeprefix(_SVG)
        if kind == "g":
            yield from _children(part, named)
        elif kind == "use":
            yield _referenced(part, named[part.get(_HREF, "")[1:]])
        elif kind == "text":
            yield _text(part)
        elif kind == "path":
            declared = part.get("style", "")
            if "stroke:" in declared or "fill: none" not in declared:  # else it cannot be seen
                yield _path(part.get("d", ""), declared)


def _referenced(use: ElementTree.Element, path: ElementTree.Element) -> ElementTree.Element:
    """A mark: the path that `use` names, at its place."""
    out = _path(path.get("d", ""), use.get("style", ""))
    x, y = (_rounded(use.get(name, "0")) for name in ("x", "y"))
    out.set("transform", f"translate({x} {y})")
    return out


def _path(steps: str, declared: str) -> ElementTree.Element:
    d = re.sub(r"\s*([A-Za-z])\s*", r"\1", _rounded(steps)).replace("\n", " ").strip()
    return ElementTree.Element("path", {"d": d, "style": _themed(declared)})


def _text(part: ElementTree.Element) -> ElementTree.Element:
    out = ElementTree.Element("text", {name: _rounded(part.get(name, "0")) for name in ("x", "y")})
    declared = _themed(part.get("style", ""))
    if declared:
        out.set("style", declared)
    out.text = part.text
    return out


def _themed(declared: str) -> str:
    """Declarations of style with the variables of the style sheet for colours."""
    kept = _DEFAULTS.sub("", declared).replace("text-anchor: start", "")
    for name, colour in COLOURS.items():
        kept = kept.replace(colour, f"var(--{name})")
    return kept.strip("; ").replace(": ", ":").replace("; ", ";")


def _rounded(numbers: str) -> str:
    return _NUMBER.sub(lambda found: f"{float(found[0]):.1f}".removesuffix(".0"), numbers)
