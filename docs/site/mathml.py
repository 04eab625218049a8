"""Equations as MathML, made when the site is built: no script, no font, no network."""

from __future__ import annotations

from latex2mathml.converter import convert

#: LaTeX that the converter has under other names.
_NAMES = {r"\bigl": r"\left", r"\bigr": r"\right", r"\bigm": ""}


def _mathml(text: str, display: str) -> str:
    for name, other in _NAMES.items():
        text = text.replace(name, other)
    return convert(text, display=display)


def _inline(self, node):
    from docutils import nodes

    self.body.append(_mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(self, node):
    from docutils import nodes

    self.body.append(f'<div class="equation">{_mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True}
