"""The page of `halfphysics judge`: one HTML file without scripts or requests, bars over clips."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import replace
from statistics import fmean, median

from halfphysics.cli.judge_tables import digits, shown_names, taken, values_of, worst_of
from halfphysics.judging.judge import Judged
from halfphysics.metrics.measures import Measure

#: Bars of a chart; of more clips only the worst are drawn.
BARS = 300
#: Size of a chart [pixels].
_WIDTH, _HEIGHT = 900, 120
_STYLE = """\
:root { color-scheme: light dark; --bar: #4477aa; --worst: #cc6677; --line: #8888; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 960px; margin: 2em auto; padding: 0 1em; }
h2 { font-size: 1.1em; margin: 2em 0 0; }
p { margin: 0.2em 0; }
.small { font-size: 0.85em; opacity: 0.8; }
svg { width: 100%; height: auto; border-bottom: 1px solid var(--line); }
rect { fill: var(--bar); } rect.worst { fill: var(--worst); }
table { border-collapse: collapse; display: block; overflow-x: auto; }
td, th { padding: 0.15em 0.6em; border-bottom: 1px solid var(--line); text-align: right; }
td:first-child, th:first-child, td:last-child { text-align: left; }
"""


def page(people: Sequence[Judged]) -> str:
    """The page of some verdicts."""
    names = shown_names(people)
    measured = [replace(one, name=names[one.name]) for one in people if one.verdict is not None]
    failed = [one for one in people if one.verdict is None]
    measures = taken(measured)
    head = f"{len(measured)} {'clip' if len(measured) == 1 else 'clips'} judged"
    if failed:
        head += f", {len(failed)} not"
    blocks = [f"<h1>{head}</h1>", _table(measured, measures)]
    blocks += [_section(measured, measure) for measure in measures]
    if failed:
        items = "".join(f"<li>{html.escape(one.error)}</li>" for one in failed)
        blocks.append(f"<h2>Not judged</h2><ul>{items}</ul>")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        f"<title>{head}</title><style>{_STYLE}</style></head><body>\n"
        + "\n".join(blocks)
        + "\n</body></html>\n"
    )


def _table(people: Sequence[Judged], measures: Sequence[Measure]) -> str:
    rows = ["<tr><th>measure<th>mean<th>median<th>worst<th>better<th>worst clip</tr>"]
    for measure in measures:
        found = values_of(people, measure)
        if not found:
            continue
        name, worst = worst_of(found, measure)
        numbers = [value for _, value in found]
        cells = "".join(f"<td>{digits(x)}" for x in (fmean(numbers), median(numbers), worst))
        rows.append(
            f'<tr><td><a href="#{measure.key}">{html.escape(measure.label)}</a>{cells}'
            f"<td>{_arrow(measure)}<td>{html.escape(name)}</tr>"
        )
    return f"<table>{''.join(rows)}</table>"


def _section(people: Sequence[Judged], measure: Measure) -> str:
    found = values_of(people, measure)
    note = f"{measure.better} is better"
    if len(found) > BARS:
        found = sorted(found, key=lambda pair: pair[1], reverse=measure.better == "lower")[:BARS]
        note += f"; the {BARS} worst clips"
    head = (
        f'<h2 id="{measure.key}">{html.escape(measure.label)} {_arrow(measure)}</h2>'
        f"<p>{html.escape(measure.definition)}</p>"
        f'<p class="small">{html.escape(measure.source)}; {note}</p>'
    )
    return head + (_bars(found, measure) if found else "<p>No clip has a value.</p>")


def _bars(found: Sequence[tuple[str, float]], measure: Measure) -> str:
    """A bar for each clip, its name and value shown under the pointer."""
    most = max(abs(value) for _, value in found) or 1.0
    worst = worst_of(found, measure)
    step = _WIDTH / len(found)
    width = min(0.8 * step, 60.0)
    bars = []
    for k, (name, value) in enumerate(found):
        height = max(abs(value) / most * (_HEIGHT - 20), 0.5)
        kind = ' class="worst"' if (name, value) == worst and len(found) > 1 else ""
        words = html.escape(f"{name}: {digits(value)} {measure.unit}".rstrip())
        bars.append(
            f'<rect{kind} x="{k * step:.1f}" y="{_HEIGHT - height:.1f}" width="{width:.1f}" '
            f'height="{height:.1f}"><title>{words}</title></rect>'
        )
    top = f'<text x="0" y="12" font-size="12" fill="currentColor">{digits(most)}</text>'
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="{html.escape(measure.label)}">{top}{"".join(bars)}</svg>'
    )


def _arrow(measure: Measure) -> str:
    return "&uarr;" if measure.better == "higher" else "&darr;"
