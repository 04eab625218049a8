"""Pages in a headless Chromium: the system's own, driven by playwright."""

from __future__ import annotations

import base64
import contextlib
import importlib.util
import io
import os
import shutil
import time
from pathlib import Path

#: The browser to use; None: no browser, or no driver for it. None is ever downloaded.
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
if importlib.util.find_spec("playwright") is None:
    CHROMIUM = None
_FLAGS = (
    *("--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-quic"),
    *("--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"),
    *("--hide-scrollbars", "--use-gl=angle", "--use-angle=swiftshader"),
    "--enable-unsafe-swiftshader",
)
_DROP = """(files) => {
  const dataTransfer = new DataTransfer();
  for (const [name, data] of files) {
    const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
    dataTransfer.items.add(new File([bytes], name));
  }
  for (const type of ["dragenter", "dragover", "drop"]) {
    dispatchEvent(new DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
  }
}"""
#: Drawing in software takes a whole core, and pages draw all the time. Here they do so at most
#: twenty times a second, and without smooth edges, which four times the pixels are drawn for: no
#: test looks at either.
_PLAIN = """(() => {
  const context = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    const plain = /^webgl/.test(kind) ? { ...options, antialias: false } : options;
    return context.call(this, kind, plain);
  };
  const next = window.requestAnimationFrame.bind(window), waiting = new Map();
  let number = 0, asked = false, last = 0;
  const draw = (now) => {
    const calls = [...waiting.values()];
    waiting.clear();
    asked = false;
    last = performance.now();
    for (const call of calls) {
      try { call(now); } catch (error) { reportError(error); }
    }
  };
  window.requestAnimationFrame = (call) => {
    waiting.set(++number, call);
    if (!asked) setTimeout(() => next(draw), Math.max(0, last + 50 - performance.now()));
    asked = true;
    return number;
  };
  window.cancelAnimationFrame = (which) => waiting.delete(which);
})()"""
SIZES = {"desktop": (1280, 800), "phone": (390, 844)}


class Tab:
    """One page: its messages, its requests, and the values that a script finds in it."""

    def __init__(self, page):
        self.page = page
        self.complaints: list[str] = []  # all console messages
        self.errors: list[str] = []  # of these, the errors
        self.requests: list[str] = []
        page.on("console", self._said)
        page.on("pageerror", lambda error: self._failed(str(error)))
        page.on("request", lambda request: self.requests.append(request.url))

    def _said(self, message):
        self.complaints.append(message.text)
        if message.type == "error":
            self.errors.append(message.text)

    def _failed(self, text):
        self.complaints.append(text)
        self.errors.append(text)

    def size(self, width, height, dark=False):
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.emulate_media(color_scheme="dark" if dark else "light")

    def open(self, where: Path | str):
        """A file, or an address."""
        self.page.goto(where if isinstance(where, str) else where.resolve().as_uri())

    def evaluate(self, script, value=None):
        return self.page.evaluate(script, value)

    def screenshot(self, path: Path, *, whole=True):
        self.page.screenshot(path=path, full_page=whole)

    def picture(self):
        """The visible picture, (height, width, 3) of 0 to 255."""
        import numpy as np
        from PIL import Image

        data = self.page.screenshot()
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)

    def until(self, condition, seconds=150.0):
        """Wait until a condition holds in the page; a browser that draws in software is slow."""
        end = time.monotonic() + seconds
        while not (found := condition()):
            assert time.monotonic() < end, f"{seconds:g} s and still not: {condition}"
            self.page.wait_for_timeout(150)
        return found

    def drop(self, *paths: Path):
        """Drop files onto the middle of the page, as from a folder."""
        files = [[p.name, base64.b64encode(p.read_bytes()).decode()] for p in paths]
        self.page.evaluate(_DROP, files)

    def quiet(self):
        """Close viser's message that it draws in software, which only tests see."""
        notice = self.page.locator("[role=alert] button")
        if notice.count():
            notice.first.click()

    def box(self, selector):
        """The rectangle of an element: (left, top, right, bottom) in pixels."""
        box = self.page.locator(selector).first.bounding_box()
        return box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]


@contextlib.contextmanager
def tab(folder: Path, size=SIZES["desktop"]):
    """A new page in a browser of its own, with its profile in `folder`."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            str(folder / "profile"),
            executable_path=CHROMIUM,
            args=list(_FLAGS),
            headless=True,
            viewport={"width": size[0], "height": size[1]},
        )
        context.add_init_script(_PLAIN)
        try:
            yield Tab(context.pages[0] if context.pages else context.new_page())
        finally:
            context.close()


def artefacts(folder: Path) -> Path:
    """The folder for pictures to inspect: $HALFPHYSICS_ARTEFACTS, or `folder`."""
    kept = Path(os.environ.get("HALFPHYSICS_ARTEFACTS") or folder)
    kept.mkdir(parents=True, exist_ok=True)
    return kept
