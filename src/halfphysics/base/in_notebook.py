"""What notebooks show of an object: a picture and some lines."""

from __future__ import annotations


class InNotebook:
    """Base of classes that notebooks show with a picture.

    `halfphysics.render.notebook` makes it when it is asked for; nothing of it runs before.
    """

    def _repr_html_(self) -> str:
        """HTML of a picture and a summary. Never raises: what fails is left out."""
        from halfphysics.render.notebook import html_of

        return html_of(self)
