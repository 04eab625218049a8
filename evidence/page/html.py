"""The report as one HTML file without requests or scripts."""

from __future__ import annotations

import base64
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from evidence.page import charts
from evidence.page.wording import (
    MISSING,
    number,
    plain,
    published,
    quantity,
    signed,
    visible,
)
from evidence.verdicts import VERDICTS, claims, tally, verdict

_STYLE = Path(__file__).with_name("style.css")
#: The browser may fetch nothing, whatever a name in the report contains.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
_PNG = b"\x89PNG\r\n\x1a\n"
#: A picture wider than this many times its height scrolls on a phone instead of shrinking.
_STRIP = 2.2

#: Sections with their anchors on the page.
Places = Sequence[tuple[str, Mapping[str, Any]]]
Pictures = Callable[[str, str, str], bytes | None]


def build(document: Mapping[str, Any], speed: Mapping[str, Any] | None, pictures: Pictures) -> str:
    """The page of a report.

    Args:
        document: The content of `paper.json`.
        speed: The content of `paper-speed.json` (the same, with "machine"), or None.
        pictures: (section's key, task's key, name) -> the bytes of a PNG, or None if there is none.

    Returns:
        The HTML text; the same for the same content.
    """
    names = _Names()
    evidence = [(names.of(s["key"]), s) for s in document["sections"]]
    timing = [(names.of("speed-" + s["key"]), s) for s in (speed or {}).get("sections", ())]
    body = [_section(anchor, section, pictures) for anchor, section in evidence]
    if speed is not None and timing:
        body.append(_machine(speed["machine"]))
        body.extend(_section(anchor, section, pictures) for anchor, section in timing)
    body.append(_legend())
    title = _e(document["title"])
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<link rel="icon" href="data:,">\n<title>{title}</title>\n'
        f"<style>\n{_STYLE.read_text(encoding='utf-8')}</style>\n</head>\n<body>\n"
        f'<div class="page first">{_head(document)}'
        f"{_summary(document, evidence, timing)}</div>\n"
        f'{_contents(evidence, timing)}\n<main class="page">\n'
        + "\n".join(body)
        + "\n</main>\n</body>\n</html>\n"
    )


class _Names:
    """Anchors of the page, made from arbitrary keys, each used once."""

    def __init__(self) -> None:
        self._given: set[str] = {"summary", "contents", "machine", "legend"}

    def of(self, key: str) -> str:
        letters = (c if c.isascii() and c.isalnum() else "-" for c in str(key).lower())
        stem = "-".join(filter(None, "".join(letters).split("-")))[:60] or "section"
        name, k = stem, 2
        while name in self._given:
            name, k = f"{stem}-{k}", k + 1
        self._given.add(name)
        return name


def _e(text: object) -> str:
    return escape(plain(text))


def _mark(kind: str, word: bool = True) -> str:
    sign, said = VERDICTS[kind]
    if word:
        return (
            f'<span class="mark {kind}"><b aria-hidden="true">{sign}</b> '
            f'<span class="word">{said}</span></span>'
        )
    return f'<span class="mark {kind}" title="{said}"><b>{sign}</b></span>'


def _tally(counts: Mapping[str, int]) -> str:
    """Numbers of the verdicts of a section, with their marks."""
    parts = (
        f'<span class="mark {kind}" title="{VERDICTS[kind][1]}">'
        f'<b aria-hidden="true">{VERDICTS[kind][0]}</b> {n}'
        f'<span class="unseen"> {VERDICTS[kind][1]}</span></span>'
        for kind, n in counts.items()
        if n
    )
    return f'<span class="tally">{" ".join(parts)}</span>'


def _contents(evidence: Places, timing: Places) -> str:
    def entries(sections: Places) -> str:
        return "".join(
            f'<li><a href="#{anchor}">{_e(s["title"])}</a>{_tally(tally([s]))}</li>'
            for anchor, s in sections
        )

    speed = f"<h2>On this machine</h2><ol>{entries(timing)}</ol>" if timing else ""
    return (
        '<nav id="contents" aria-label="Contents"><h2>Contents</h2>'
        f'<ol><li><a href="#summary">Summary</a></li>{entries(evidence)}</ol>{speed}'
        '<ol><li><a href="#legend">How to read this</a></li></ol></nav>'
    )


def _head(document: Mapping[str, Any]) -> str:
    facts = [
        ("halfphysics", document["halfphysics"]),
        ("MuJoCo", document["mujoco"]),
        ("seed", document["seed"]),
        ("run", "quick" if document["quick"] else "full"),
        *((f"data: {name}", value) for name, value in document["data"].items()),
    ]
    return f"<header><h1>{_e(document['title'])}</h1>{_facts(facts)}</header>"


def _facts(facts: Iterable[tuple[object, object]]) -> str:
    return (
        '<dl class="facts">'
        + "".join(f"<div><dt>{_e(k)}</dt><dd>{_said(v)}</dd></div>" for k, v in facts)
        + "</dl>"
    )


def _said(value: object) -> str:
    """Any JSON value as text."""
    if isinstance(value, Mapping):
        return "; ".join(f"{_e(k)} {_said(v)}" for k, v in value.items()) or MISSING
    if isinstance(value, list | tuple):
        return ", ".join(_said(v) for v in value) or MISSING
    return escape(number(value))


def _summary(document: Mapping[str, Any], evidence: Places, timing: Places) -> str:
    counts = document["verdict"]
    tiles = "".join(
        f'<li class="{kind if n else "shown"}"><b>{n:,}</b>{_mark(kind)}</li>'
        for kind, n in counts.items()
    )
    bar = "".join(
        f'<span class="{kind}" style="flex-grow:{n}"></span>' for kind, n in counts.items() if n
    )
    quick = (
        '<p class="note">This is a quick run: fewer and shorter motions and scenes, with the same '
        "rules. Without <code>--quick</code> the report is made in full.</p>"
        if document["quick"]
        else ""
    )
    speed = (
        "<p>What depends on the machine is counted apart: "
        f'<a href="#machine">on this machine</a> {_tally(tally([s for _, s in timing]))}</p>'
        if timing
        else ""
    )
    return (
        '<section id="summary"><h2>Summary</h2>'
        f'<ul class="tiles">{tiles}</ul><div class="shares" aria-hidden="true">{bar}</div>'
        f"{speed}{quick}"
        + _against([*evidence, *timing], "not_reproduced")
        + _against([*evidence, *timing], "missing")
        + _failures([*evidence, *timing])
        + "</section>"
    )


def _against(places: Places, kind: str) -> str:
    """The list of figures that are not reproduced, or missing."""
    found = [claim for claim in claims([s for _, s in places]) if claim.verdict == kind]
    if not found:
        said = "Every claim that was judged came out."
        return f'<p class="clear">{said}</p>' if kind == "not_reproduced" else ""
    lines = []
    for claim in found:
        (anchor, section), f = places[claim.section], claim.figure
        unit = f" {_e(f['unit'])}" if plain(f["unit"]) else ""
        numbers = [f"expected {_e(f['expected'])}"] if plain(f["expected"]) else []
        numbers += [f"paper {_paper(f)}{unit}"] if f["paper"] is not None else []
        if kind == "not_reproduced":
            numbers.insert(0, f"<b>ours {_ours(f)}{unit}</b>")
        lines.append(
            f'<li class="{kind}"><a href="#{anchor}.{claim.row + 1}">'
            f"{_e(section['title'])}</a> <span>{_e(section['rows'][claim.row]['name'])}, "
            f"{_e(f['name'])}: {', '.join(numbers)}</span></li>"
        )
    return _list(f"{_mark(kind, False)} {VERDICTS[kind][1].capitalize()}", lines)


def _list(head: str, lines: Sequence[str]) -> str:
    return f'<h3>{head} ({len(lines)})</h3><ul class="list">{"".join(lines)}</ul>'


def _failures(places: Places) -> str:
    lines = [
        f'<li class="missing"><a href="#{anchor}">{_e(section["title"])}</a> '
        f"<span>{_e(failed['task'])}: {_e(failed['cause'])}</span></li>"
        for anchor, section in places
        for failed in section["failed"]
    ]
    if not lines:
        return ""
    return _list("Experiments that ended in an error", lines)


def _section(anchor: str, section: Mapping[str, Any], pictures: Pictures) -> str:
    about = "".join(
        f"<p>{_e(part)}</p>" for part in str(section["about"]).split("\n\n") if plain(part)
    )
    return (
        f'<section id="{anchor}"><h2><a href="#{anchor}">{_e(section["title"])}</a></h2>'
        f"{_tally(tally([section]))}"
        f'<a class="up" href="#contents">↑ contents</a><div class="about">{about}</div>'
        + _table(anchor, section["rows"])
        + _failed(section["failed"])
        + _command(section["command"])
        + "".join(_plot(plot) for plot in section["plots"])
        + _gallery(section, pictures)
        + "</section>"
    )


def _paper(figure: Mapping[str, Any]) -> str:
    return escape(signed(published(figure["paper"])))


def _ours(figure: Mapping[str, Any]) -> str:
    return escape(signed(number(figure["ours"], beside=figure["paper"])))


def _table(anchor: str, rows: Sequence[Mapping[str, Any]]) -> str:
    if not rows:
        return ""
    head = "".join(
        f'<th scope="col" class="{kind}">{name}</th>'
        for kind, name in (
            ("what", "Experiment"),
            ("measure", "Measure"),
            ("paper", "Paper"),
            ("ours", "Ours"),
            ("expected", "Expected"),
            ("verdict", "Verdict"),
        )
    )
    parts = "".join(_row(f"{anchor}.{k}", row) for k, row in enumerate(rows, 1))
    # A section without numbers of the paper needs no column for them.
    quoting = any(f["paper"] is not None for row in rows for f in row["figures"])
    kind = "figures" if quoting else "figures alone"
    return f'<table class="{kind}"><thead><tr>{head}</tr></thead>{parts}</table>'


def _row(anchor: str, row: Mapping[str, Any]) -> str:
    figures = row["figures"]
    what = f"<b>{_e(row['name'])}</b>"
    for kind in ("data", "note"):
        if plain(row[kind]):
            what += f'<span class="{kind}">{_e(row[kind])}</span>'
    if plain(row["setting"]):
        what += f"<code>{_e(row['setting'])}</code>"
    span = f' rowspan="{len(figures)}"' if len(figures) > 1 else ""
    first = f'<th scope="rowgroup" class="what"{span}>{what}</th>'
    if not figures:
        return f'<tbody id="{anchor}"><tr>{first}<td colspan="5">{MISSING}</td></tr></tbody>'
    lines = []
    for figure in figures:
        kind = verdict(row, figure)
        expected = _e(figure["expected"])
        none = " none" if figure["paper"] is None else ""
        lines.append(
            f'<tr class="{kind}">{first}'
            f'<td class="measure">{_e(quantity(figure["name"], figure["unit"]))}</td>'
            f'<td class="paper{none}">{_paper(figure)}</td>'
            f'<td class="ours">{_ours(figure)}</td>'
            f'<td class="expected">{expected}</td><td class="verdict">{_mark(kind)}</td></tr>'
        )
        first = ""
    return f'<tbody id="{anchor}">{"".join(lines)}</tbody>'


def _failed(failed: Sequence[Mapping[str, Any]]) -> str:
    if not failed:
        return ""
    lines = "".join(f"<li><b>{_e(f['task'])}</b>: {_e(f['cause'])}</li>" for f in failed)
    return f'<div class="failed"><p>Ended in an error:</p><ul>{lines}</ul></div>'


def _command(command: object) -> str:
    """A command to copy; lines break between its words only."""
    if not plain(command):
        return ""
    words = " ".join(f"<span>{escape(word)}</span>" for word in visible(command).split(" "))
    return f'<div class="command"><b>Made by</b><pre><code>{words}</code></pre></div>'


def _plot(plot: Mapping[str, Any]) -> str:
    if charts.is_empty(plot):
        return (
            f'<figure class="plot"><figcaption><b>{_e(plot["title"])}</b></figcaption>'
            '<p class="note">There is nothing to draw: no value came out.</p></figure>'
        )
    kind = charts.kind_of(plot)
    legend = "".join(
        f"<li>{charts.swatch(k, kind)}{_e(series['name'])}</li>"
        for k, series in enumerate(plot["series"])
        if plain(series["name"])
    )
    said = "; ".join(charts.scales(plot))
    note = f'<span class="scale">{said[:1].upper()}{said[1:]}.</span>' if said else ""
    return (
        f'<figure class="plot"><figcaption><b>{_e(plot["title"])}</b>{note}</figcaption>'
        + (f'<ul class="series">{legend}</ul>' if legend else "")
        + f'<div class="wide">{charts.draw(plot, charts.WIDE)}</div>'
        f'<div class="narrow">{charts.draw(plot, charts.NARROW)}</div></figure>'
    )


def _gallery(section: Mapping[str, Any], pictures: Pictures) -> str:
    shown = "".join(
        _picture(pictures(section["key"], p["task"], p["name"]), p["caption"])
        for p in section["pictures"]
    )
    return f'<div class="gallery">{shown}</div>' if shown else ""


def _picture(png: bytes | None, caption: object) -> str:
    said = _e(caption)
    if png is None or png[:8] != _PNG or len(png) < 24:
        return (
            f'<figure class="picture"><p class="note">No picture came out.</p>'
            f"<figcaption>{said}</figcaption></figure>"
        )
    width, height = struct.unpack(">II", png[16:24])
    data = base64.b64encode(png).decode("ascii")
    strip = width > _STRIP * height
    image = (
        f'<img src="data:image/png;base64,{data}" width="{width}" height="{height}" alt="{said}">'
    )
    if strip:
        image = f'<div class="strip" tabindex="0" role="group" aria-label="{said}">{image}</div>'
    kind = "picture across" if strip else "picture"
    return f'<figure class="{kind}">{image}<figcaption>{said}</figcaption></figure>'


def _machine(machine: Mapping[str, Any]) -> str:
    return (
        '<section id="machine" class="divider"><h2>On this machine</h2>'
        "<p>What follows depends on the machine and on what else it did; everything above does "
        f"not.</p>{_facts(machine.items())}</section>"
    )


def _legend() -> str:
    meanings = {
        "reproduced": "ours meets what is expected: what the paper claims comes out.",
        "direction": "ours goes the paper's way by the smallest size that is expected; how much "
        "more depends on the data, so both sizes are shown.",
        "not_reproduced": "ours does not meet what is expected.",
        "shown": "no pass or fail: the number stands beside the paper's, or for itself.",
        "missing": "something is expected, but the experiment did not run or ended in an error.",
        "quoted": "the paper's number for a method that is not run here.",
    }
    lines = "".join(f"<li>{_mark(kind)}<span>{text}</span></li>" for kind, text in meanings.items())
    return (
        f'<section id="legend"><h2>How to read this</h2><ul class="legend">{lines}</ul>'
        "<p>Ours is in bold. Where the paper has a number, ours has at least its decimals, up to "
        f"six digits; {MISSING} stands where there is none. The file <code>paper.json</code> "
        "beside this page has every number in full.</p></section>"
    )
