"""Films and pictures of results, on a machine without GPU or display.

`save_film` writes .mp4, .webm and .gif, `save_picture` .png; both take `FilmOptions`. The simulated
body is solid, the reference is a translucent ghost.
"""

from halfphysics.render.film.options import CAMERAS, FilmOptions
from halfphysics.render.film.saving import FILMS, save_film, save_picture

__all__ = ["CAMERAS", "FILMS", "FilmOptions", "save_film", "save_picture"]
