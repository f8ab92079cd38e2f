"""Answers that draw themselves: the methods of theirs that ask the pictures of the package."""

from __future__ import annotations

from pkgutil import resolve_name
from typing import Any

from surefoot.base.errors import MissingExtra

_PICTURES = "surefoot.app.viz.drawings"
"""Module of the pictures, loaded with the first of them: its table says which function draws which class."""


class Drawn:
    """Something with a picture: a method `plot`, and the pictures that a notebook shows of its own accord."""

    __slots__ = ()

    def plot(self, axes: Any = None, **options: Any) -> Any:
        """Draw this on Matplotlib axes, and return them.

        Parameters
        ----------
        axes
            Axes to draw on, plane or three-dimensional where the picture has both; None for a figure of its
            own (one of pyplot's, where pyplot is loaded already, so that ``plt.show()`` shows it).
        options
            Of the picture of this kind, as docs/pictures.md lists them.

        Returns
        -------
        Any
            The axes; an array of them for pictures of several panels, which take no axes.

        Raises
        ------
        ProblemError
            If the axes are none, or an option is unknown.
        MissingExtra
            If matplotlib is not installed.
        """
        return resolve_name(f"{_PICTURES}:plot")(self, axes, **options)

    def _repr_png_(self) -> bytes | None:
        """Return the picture that a notebook shows; None, for none, where matplotlib is not installed."""
        try:
            return bytes(resolve_name(f"{_PICTURES}:png_of")(self))
        except MissingExtra:
            return None

    def _repr_html_(self) -> str | None:
        """Return the sentence and the picture that a notebook shows."""
        import base64
        import html

        image = self._repr_png_()
        if image is None:
            return None
        text = html.escape(str(self))
        data = base64.b64encode(image).decode("ascii")
        return f'<p>{text}</p><img alt="{text}" style="max-width:100%" src="data:image/png;base64,{data}">'
