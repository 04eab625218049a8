"""Sphinx's settings for the site of the documents (tools/build_site.py)."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

from sphinx.ext.napoleon import Config, GoogleDocstring

import halfphysics

project = "halfphysics"
copyright = "the halfphysics contributors, Apache-2.0"
version = release = halfphysics.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "sphinx.ext.mathjax",
]

# -- Equations: MathJax, one script with its letters, in the site itself
_mathjax = importlib.util.find_spec("sphinx-mathjax-offline").submodule_search_locations[0]
_mathjax_script = Path(_mathjax) / "static" / "mathjax" / "tex-svg.js"
mathjax_path = "mathjax/tex-svg.js"
mathjax3_config = {"svg": {"fontCache": "global"}, "options": {"enableMenu": False}}

# -- Markdown, in the dialect of GitHub
myst_heading_anchors = 4
myst_fence_as_directive = ["math"]

# -- Docstrings
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "none"  # docstrings say shapes and units
autodoc_class_signature = "mixed"
_GOOGLE = Config(
    napoleon_use_ivar=True,
    napoleon_use_rtype=False,
    napoleon_attr_annotations=False,  # shapes and units are in the docstrings
)
python_maximum_signature_line_length = 88
add_module_names = False
toc_object_entries_show_parents = "hide"

# -- Look
html_theme = "furo"
html_title = "halfphysics"
smartquotes_action = "D"  # dashes between names and their descriptions
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
templates_path: list[str] = []
pygments_style = "friendly"
pygments_dark_style = "github-dark"
copybutton_prompt_text = "$ "
_LIGHT = {
    "color-brand-primary": "#0b5394",
    "color-brand-content": "#0b5394",
    "color-background-primary": "#fcfcfa",
    "color-background-secondary": "#f4f5f3",
}
_DARK = {
    "color-brand-primary": "#7db8ee",
    "color-brand-content": "#7db8ee",
    "color-background-primary": "#14171a",
    "color-background-secondary": "#1b1f23",
}
_FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif'
html_theme_options = {
    "light_css_variables": {**_LIGHT, "font-stack": _FONT},
    "dark_css_variables": {**_DARK, "font-stack": _FONT},
    "navigation_with_keys": True,
}

#: In docstrings these are signs, not markup; what is in backquotes is left as it is.
_MARKUP = re.compile(r"(``[^`]*``|`[^`]*`)|([*|_\\])")
_LITERAL = re.compile(r"::$")


def _plain(app, what, name, obj, options, lines):
    """Escape reStructuredText in sentences; blocks after `::` are left as they are. Then sections
    (Args, Raises) become fields; called here, as napoleon takes "What it is: more" of a property
    for a type."""
    indent = None
    for k, line in enumerate(lines):
        here = len(line) - len(line.lstrip())
        if indent is not None and line.strip() and here <= indent:
            indent = None
        if indent is None:
            lines[k] = _MARKUP.sub(lambda m: m[1] or f"\\{m[2]}", line)
            if _LITERAL.search(line):
                indent = here
    kind = what if what in ("module", "class") else "method"
    lines[:] = GoogleDocstring(lines, _GOOGLE, app, kind, name, obj, options).lines()


def _defaults(app, what, name, obj, options, signature, returned):
    """What a dataclass makes anew for each object has no value to show."""
    return signature and signature.replace("<factory>", "..."), returned


def _copy_mathjax(app):
    target = Path(app.outdir) / "_static" / "mathjax" / "tex-svg.js"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(_mathjax_script.read_bytes())


def setup(app):
    """Called by Sphinx."""
    app.connect("builder-inited", _copy_mathjax)
    app.connect("autodoc-process-signature", _defaults)
    app.connect("autodoc-process-docstring", _plain)
