"""A Matplotlib figure that a notebook shows as a picture, without pyplot and without ``%matplotlib``."""

from __future__ import annotations

from io import BytesIO

from matplotlib import figure


class Figure(figure.Figure):
    """Matplotlib's figure; as the last line of a notebook's cell it is shown."""

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png")
        return picture.getvalue()
