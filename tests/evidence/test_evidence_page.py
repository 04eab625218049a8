"""The report's page: complete in one file, verdicts first, readable on a phone."""

from __future__ import annotations

import re
from html.parser import HTMLParser

import evidence_sample as sample
import pytest

from evidence.page import html
from evidence.verdicts import VERDICTS
from support.browser import CHROMIUM, tab

SIZES = {"desktop": (1280, 800), "phone": (390, 844), "small": (320, 568), "between": (700, 900)}
VOID = {"meta", "link", "img"}


class Parsed(HTMLParser):
    """Elements and texts; every opened element is closed in order."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.texts, self.ids = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.ids += [v for k, v in attrs if k == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.texts.append(data)


@pytest.fixture(scope="module")
def made():
    return html.build(sample.document(), sample.speed(), sample.pictures)


@pytest.fixture(scope="module")
def parsed(made):
    return Parsed(made)


def minimal(**changes):
    """A report of one section."""
    part = {**sample.section("x", "X", "", []), **changes}
    return {**sample.document(), "sections": [part]}


def test_the_page_is_whole_in_itself(made, parsed):
    assert made.startswith("<!doctype html>")
    assert re.findall(r"https?://[^\s\"']*", made) == []
    assert "@import" not in made
    assert "url(" not in made
    assert {tag for tag, _ in parsed.elements} & {"script", "iframe", "object", "form"} == set()
    for tag, attributes in parsed.elements:
        assert not any(name.startswith("on") for name in attributes)
        for name in ("src", "href"):
            where = attributes.get(name, "#")
            assert where.startswith(("#", "data:")), (tag, where[:50])
    made.encode("utf-8")


def test_links_lead_somewhere_and_names_are_given_once(parsed):
    assert len(parsed.ids) == len(set(parsed.ids))
    targets = {a["href"][1:] for tag, a in parsed.elements if tag == "a"}
    assert targets <= set(parsed.ids)
    assert {"summary", "table1", "table4", "figure8", "speed-speed", "legend"} <= targets
    assert "table2.2" in targets  # the row that is not reproduced


def test_what_is_not_reproduced_is_said_before_everything_else(made):
    first = made.index("<h3>")
    assert made.index("Not reproduced (2)") < made.index("Missing (2)") < made.index("<nav")
    assert made[first:].index("<b>ours 0.0213 mm</b>, expected 0.00, paper 0 mm") > 0
    assert made.index("<b>ours 4.020 mm</b>, expected at least 10") < made.index("<table")
    assert made.index("damaged archive") < made.index("<table")


def test_every_figure_is_there_with_its_verdict(made):
    rows = re.findall(r'<td class="verdict"><span class="mark (\w+)"><b aria-hidden="true">(.)',
                      made)  # fmt: skip
    expected = {kind: 0 for kind in VERDICTS}
    for kind, _ in rows:
        expected[kind] += 1
    counts = {k: sample.document()["verdict"][k] + sample.speed()["verdict"][k]
              for k in VERDICTS if k != "quoted"}  # fmt: skip
    counts["missing"] -= 2  # tasks that ended in an error have no row
    assert expected == {**counts, "quoted": 2}
    assert {mark for _, mark in rows} == set("✓↗✗·–“")


def test_a_section_without_numbers_of_the_paper_has_no_column_of_them(made):
    kinds = re.findall(r'<section id="([^"]*)">(?:(?!</section>).)*?<table class="([^"]*)"', made)
    assert dict(kinds) == {
        **dict.fromkeys(["table1", "table2", "table3", "table4", "speed-speed"], "figures"),
        **dict.fromkeys(["figure5", "figure8"], "figures alone"),
    }


def test_texts_are_escaped_and_steer_nothing(made, parsed):
    assert "<script" not in made
    whole = "".join(parsed.texts)
    assert "<script>alert(1)</script> \"&'" in whole
    assert not set("\x1b\u202e\udcff") & set(made)
    assert "\ufffd" in whole
    hostile = minimal(
        key='"><img src=x>', title="<b>", about="<i>\n\n</p>", command="<u>",
        rows=[sample.row("<s>", [sample.figure("<q>", "<em>", 1.0, 2.0, "<a>", False)],
                         "<hr>", "<tt>", "<br>")],
        plots=[sample.plot("<p1>", ("<p2>", "<p3>"), ("<p4>", "<p5>"),
                           sample.series("<p6>", [0, 1], [1, 2]))],
        pictures=[{"caption": '"><p7>', "task": "t", "name": "strip"}],
        failed=[{"task": "<p8>", "cause": "<p9>"}],
    )  # fmt: skip
    found = Parsed(html.build(hostile, None, sample.pictures))
    tags = {tag for tag, _ in found.elements}
    assert not tags & {"i", "u", "s", "q", "em", "hr", "tt", "br", *(f"p{k}" for k in range(10))}
    assert sum(tag == "img" for tag, _ in found.elements) == 1


def test_keys_become_names_that_links_can_carry():
    names = html._Names()
    assert [names.of(k) for k in ("Table 1", "table-1", "舞", "", "summary", "a" * 200)] == [
        "table-1", "table-1-2", "section", "section-2", "summary-2", "a" * 60]  # fmt: skip


def test_pictures_are_in_the_page_and_missing_ones_are_said(made, parsed):
    images = [a for tag, a in parsed.elements if tag == "img"]
    assert [(a["width"], a["height"]) for a in images] == [("1500", "300")] + [("640", "480")] * 2
    assert [a["alt"] for a in images] == [
        "A kick at a ball of 0.5 kg: every tenth frame", "λ = 0", "λ = 1"]  # fmt: skip
    assert made.count("No picture came out.") == 1
    odd = minimal(pictures=[{"caption": "c", "task": "t", "name": "n"}])
    for data in (b"", b"GIF89a", b"\x89PNG\r\n\x1a\n"):
        assert "No picture came out." in html.build(odd, None, lambda *_, d=data: d)


def test_without_speed_there_is_no_machine(made):
    assert 'id="machine"' in made
    for speed in (None, {**sample.speed(), "sections": []}):
        without = html.build(sample.document(), speed, sample.pictures)
        assert "machine" not in without.split("</style>")[1]


def test_speed_that_is_not_reached_is_said_at_the_top_too():
    speed = sample.speed()
    speed["sections"][0]["rows"][0]["figures"][0].update(ours=12.5, reproduced=False)
    made = html.build(sample.document(), speed, sample.pictures)
    assert "Not reproduced (3)" in made
    assert made.index('<a href="#speed-speed.1">Speed</a>') < made.index("<nav")


def test_a_report_in_which_all_came_out_says_so():
    good = html.build(minimal(), None, sample.pictures)
    assert "Every claim that was judged came out." in good
    assert "<h3>" not in good
    assert "<table" not in good


def test_plots_without_values_say_so():
    empty = sample.plot("p", ("a", ""), ("b", ""), sample.series("s", [1], [None]))
    assert "There is nothing to draw" in html.build(minimal(plots=[empty]), None, sample.pictures)


def test_the_same_report_makes_the_same_page(made):
    assert html.build(sample.document(), sample.speed(), sample.pictures) == made


@pytest.fixture(scope="module")
def chromium(tmp_path_factory, made):
    if CHROMIUM is None:
        pytest.skip("no chromium")
    folder = tmp_path_factory.mktemp("browser")
    path = folder / "paper.html"
    path.write_text(made, encoding="utf-8")
    with tab(folder) as one:
        one.path = path
        yield one


LAYOUT = """(async () => {
  await Promise.all([...document.images].map(i => i.decode()));
  const seen = e => e.getClientRects().length > 0;
  const box = e => e.getBoundingClientRect();
  const wrong = [];
  for (const svg of document.querySelectorAll("svg[role=img]")) {
    if (!seen(svg)) continue;
    const all = box(svg), texts = [...svg.querySelectorAll("text")];
    for (const [k, t] of texts.entries()) {
      const b = box(t);
      if (b.left < all.left - 0.5 || b.right > all.right + 0.5 || b.top < all.top - 0.5 ||
          b.bottom > all.bottom + 0.5) wrong.push("outside: " + t.textContent);
      for (const u of texts.slice(k + 1)) {
        const c = box(u);
        if (Math.min(b.right, c.right) - Math.max(b.left, c.left) > 0 &&
            Math.min(b.bottom, c.bottom) - Math.max(b.top, c.top) > 4)
          wrong.push("overlap: " + t.textContent + " / " + u.textContent);
      }
    }
  }
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  let smallest = 99, texts = 0;
  while (walk.nextNode()) {
    const e = walk.currentNode.parentElement;
    if (!walk.currentNode.data.trim() || !seen(e)) continue;
    texts += 1;
    smallest = Math.min(smallest, parseFloat(getComputedStyle(e).fontSize));
  }
  return {
    wide: document.scrollingElement.scrollWidth, smallest, texts, wrong,
    images: [...document.images].every(i => i.complete && i.naturalWidth > 0),
    plots: [...document.querySelectorAll("svg[role=img]")].filter(seen).length,
    clipped: [...document.querySelectorAll("td, th, li, figcaption, p, h1, h2, h3, dd")]
      .filter(e => seen(e) && !e.closest(".unseen, thead") && getComputedStyle(e).clipPath == "none"
              && e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0)
      .map(e => e.textContent.slice(0, 60)),
  };
})()"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_it_reads_well_in_a_browser(chromium, size, dark):
    width, height = SIZES[size]
    chromium.size(width, height, dark)
    chromium.open(chromium.path)
    found = chromium.evaluate(LAYOUT)
    plots = [p for d in (sample.document(), sample.speed()) for s in d["sections"]
             for p in s["plots"]]  # fmt: skip
    assert found["wide"] <= width
    assert found["smallest"] >= 14
    assert found["wrong"] == []
    assert found["clipped"] == []
    assert found["images"]
    assert found["plots"] == len(plots)  # each once, for a page or for a phone
    assert found["texts"] > 300
    assert chromium.complaints == []
    assert {r.split(":")[0] for r in chromium.requests} <= {"file", "data"}
    assert {r for r in chromium.requests if r.startswith("file")} == {chromium.path.as_uri()}


CONTRAST = """(() => {
  const light = c => {
    const [r, g, b] = c.match(/[\\d.]+/g).slice(0, 3).map(Number).map(v => v / 255)
      .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = e => {
    for (; e; e = e.parentElement) {
      const c = getComputedStyle(e).backgroundColor;
      if (c != "rgba(0, 0, 0, 0)") return c;
    }
  };
  return [...document.querySelectorAll("p, li, td, th, h1, h2, h3, a, code, dt, dd, .mark, text")]
    .filter(e => e.getClientRects().length)
    .map(e => {
      const style = getComputedStyle(e);
      const [a, b] = [light(e.tagName == "text" ? style.fill : style.color), light(behind(e))];
      return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.outerHTML.slice(0, 80)];
    })
    .sort((x, y) => x[0] - y[0])[0];
})()"""


@pytest.mark.parametrize("size", SIZES)
def test_a_click_selects_the_command_as_it_is_typed(chromium, tmp_path, size):
    command = "./run evidence --only table1 --quick --data 'aist=/a  b/" + "long/" * 40 + "'"
    path = tmp_path / "command.html"
    path.write_text(html.build(minimal(command=command), None, sample.pictures), encoding="utf-8")
    chromium.size(*SIZES[size])
    chromium.open(path)
    at = """(() => {
      const e = document.querySelector("pre");
      e.scrollIntoView({behavior: "instant"});
      const b = e.querySelector("span").getBoundingClientRect(); return [b.x + 5, b.y + 5]; })()"""
    x, y = chromium.evaluate(at)
    chromium.page.mouse.click(x, y)
    assert chromium.evaluate("getSelection().toString()").strip() == command
    assert chromium.evaluate("document.scrollingElement.scrollWidth") <= SIZES[size][0]
    heights = """[...document.querySelectorAll("pre span")].filter(s => s.textContent == "--quick")
      .map(s => s.getBoundingClientRect().height)"""
    (height,) = chromium.evaluate(heights)
    assert height < 30.0  # an option is on one line


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", ["desktop", "phone"])
def test_everything_can_be_told_from_what_is_behind_it(chromium, size, dark):
    """WCAG 2's contrast for text (AA)."""
    chromium.size(*SIZES[size], dark)
    chromium.open(chromium.path)
    ratio, where = chromium.evaluate(CONTRAST)
    assert ratio >= 4.5, where
