"""The page: one file without scripts or requests, a bar for each clip and measure."""

from __future__ import annotations

import re
from html.parser import HTMLParser

from halfphysics.cli.judge_page import BARS, page
from halfphysics.judging.judge import Judged
from halfphysics.metrics.verdict import Verdict


def clip(name: str, **values: float) -> Judged:
    return Judged(name, Verdict(values=values, missing={}, frames=9, fps=30.0))


class Bars(HTMLParser):
    """Heights and classes of the bars, and all tags."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.heights: list[float] = []
        self.worst: list[int] = []
        self.tags: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag == "rect":
            given = dict(attrs)
            if given.get("class") == "worst":
                self.worst.append(len(self.heights))
            self.heights.append(float(given["height"] or "nan"))


def test_bars_are_as_long_as_values():
    said = page([clip("x/a.npz", float_mm=10.0), clip("x/b.npz", float_mm=40.0)])
    bars = Bars(said)
    assert bars.heights[1] == 4.0 * bars.heights[0]
    assert bars.worst == [1]
    assert "<title>b.npz: 40 mm</title>" in said
    assert "mean height of the lowest vertex above the ground" in said


def test_it_needs_nothing_else_and_names_are_text():
    said = page([clip("<b>&.npz", bose_percent=50.0), Judged("bad", error="<script>no</script>")])
    tags = Bars(said).tags
    assert not tags & {"script", "link", "img", "iframe", "b"}
    assert not re.search(r"https?://|url\(", said)
    assert "&lt;b&gt;&amp;.npz" in said
    assert "1 clip judged, 1 not" in said


def test_of_thousands_the_worst_are_drawn():
    many = [clip(f"c{k}", bose_percent=float(k)) for k in range(2 * BARS)]
    said = page(many)
    assert len(Bars(said).heights) == BARS
    assert f"the {BARS} worst clips" in said
    assert "<title>c0: 0 %</title>" in said
    assert f"<title>c{2 * BARS - 1}:" not in said


def test_a_measure_without_values_is_said():
    assert "No clip has a value." in page([clip("a", stability_error_mm=float("nan"))])
