"""A film of a logged run: forces inside their cones, pushes, gait, speed, clock, and whether laws held."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from surefoot.app.viz import palette
from surefoot.app.viz.film_facts import FilmFacts, film_facts
from surefoot.app.viz.palette import rgb
from surefoot.app.viz.video import (
    ARROW_LENGTH,
    CONE_COLOUR,
    FORCE_COLOUR,
    PUSH_COLOUR,
    Arrow,
    Renderer,
    RenderError,
    cone_lines,
    edge_lines,
    log_arrows,
)
from surefoot.base.errors import needs
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain
from surefoot.records import Log

INK, PAPER = rgb(palette.INK), rgb(palette.PAPER)
TEXT_SHARE = 0.026
"""Height of the text as a share of the picture's."""
GAIT_SECONDS = 2.0
"""Shown by the gait's bars [s]."""


Entry: TypeAlias = tuple[tuple[float, ...], str]
"""Part of the legend: a colour (red, green, blue, opacity) and its words."""


class Overlay:
    """Writes over pictures of one size.

    Parameters
    ----------
    width, height
        Of the pictures [pixels].
    title
        What stands at the bottom.
    legend
        What the drawn things are, in their order; it stands at the top.

    Raises
    ------
    MissingExtra
        If Pillow, which imageio brings, is not installed.
    """

    def __init__(self, width: int, height: int, title: str, legend: Sequence[Entry]) -> None:
        with needs("imageio", "sim"):
            from PIL import Image, ImageDraw, ImageFont
        self._image, self._draw = Image, ImageDraw
        self._size, self._title = (width, height), title
        self._text = max(round(TEXT_SHARE * height), 9)
        self._font = ImageFont.load_default(size=self._text)
        self._strip = self._legend(legend)

    def _legend(self, legend: Sequence[Entry]) -> Any:
        """Return the legend on a strip as wide as the pictures."""
        width, text = self._size[0], self._text
        strip = self._image.new("RGBA", (width, 2 * text), (*PAPER, 205))
        draw = self._draw.Draw(strip)
        lengths = [draw.textlength(words, font=self._font) for _, words in legend]
        room = max((width - sum(lengths) - 2.9 * text * len(legend)) / max(len(legend), 1), 0.0)
        at = float(text)
        for (colour, words), length in zip(legend, lengths, strict=True):
            shade = tuple(round(255 * c) for c in colour[:3])
            draw.rounded_rectangle([at, 0.6 * text, at + 1.4 * text, 1.4 * text], 0.2 * text, fill=shade)
            draw.text((at + 1.9 * text, text), words, fill=(*INK, 255), font=self._font, anchor="lm")
            at += length + 2.9 * text + min(room, 2.0 * text)
        return strip

    def over(self, picture: Any, time: float, facts: FilmFacts | None = None, step: int = 0) -> Any:
        """Return a (height, width, 3) picture with title, legend and a clock at `time` [s] over it.

        With `facts` there are speed, bars of the gait and a badge of the laws at a row as well.
        """
        image = self._image.fromarray(picture)
        draw = self._draw.Draw(image, "RGBA")
        image.paste(self._strip, (0, 0), self._strip)
        clock = f"{time:.2f} s"
        if facts is not None:
            self._bars(draw, facts, step)
            self._badge(draw, facts.badge(time))
            clock = clock if facts.speed is None else f"{facts.speed[step]:.2f} m/s    {clock}"
        corner = (self._size[0] - self._text, self._size[1] - self._text)
        draw.text((self._text, corner[1]), self._title, fill=INK, font=self._font, anchor="lm")
        draw.text(corner, clock, fill=INK, font=self._font, anchor="rm")
        return np.asarray(image)

    def _bars(self, draw: Any, facts: FilmFacts, step: int) -> None:
        """Draw which contact carried when in the last seconds, now at the right."""
        text, rows = self._text, len(facts.names)
        words = [name.removesuffix("_foot")[:12] for name in facts.names]
        left = 1.5 * text + max((draw.textlength(word, font=self._font) for word in words), default=0.0)
        width, height = 0.22 * self._size[0], 0.9 * text
        top = self._size[1] - 2.0 * text - 1.2 * text * rows
        ground = [0.5 * text, top - 0.4 * text, left + width + 0.5 * text, top + 1.2 * text * rows]
        draw.rounded_rectangle(ground, 0.3 * text, fill=(*PAPER, 170))
        for k, (word, spans) in enumerate(zip(words, facts.spans(step, GAIT_SECONDS), strict=True)):
            high = top + 1.2 * text * k
            draw.text((text, high + 0.5 * height), word, fill=INK, font=self._font, anchor="lm")
            for begin, end in spans:
                box = [left + begin * width, high, left + end * width, high + height]
                draw.rectangle(box, fill=rgb(palette.LINES[k % len(palette.LINES)]))

    def _badge(self, draw: Any, told: tuple[str, bool] | None) -> None:
        """Draw whether the laws have held so far, at the upper right."""
        if told is None:
            return
        words, holds = told
        text, right = self._text, self._size[0] - self._text
        left = right - draw.textlength(words, font=self._font) - 1.4 * text
        box = [left, 2.6 * text, right, 4.4 * text]
        draw.rounded_rectangle(box, 0.5 * text, fill=rgb(palette.GOOD if holds else palette.BAD))
        draw.text((left + 0.7 * text, 3.5 * text), words, fill=PAPER, font=self._font, anchor="lm")


WIDTH, HEIGHT, RATE = 1280, 720, 25
RIM = 20
"""Sides of the polygon that stands for a cone's rim."""


class FilmScene:
    """What is drawn of a log besides the robot, frame by frame.

    Parameters
    ----------
    log
        Of a run, with its contacts.
    terrain
        The ground.
    scale
        Length of a newton [m/N].
    height
        Of the base, by which a push is drawn above it [m].
    """

    def __init__(self, log: Log, terrain: Terrain, scale: float, height: float = 0.3) -> None:
        self.log, self.terrain, self.scale = log, terrain, scale
        self._above = np.array([0.0, 0.0, 0.4 * height])
        self.edges = edge_lines(terrain)

    def legend(self) -> list[Entry]:
        """Return the legend: only what happens in this log."""
        log = self.log
        entries: list[Entry] = [
            (FORCE_COLOUR, "force of the ground"),
            (CONE_COLOUR, "friction cone, up to its normal part"),
        ]
        if np.any(log["push"]):
            largest = float(np.linalg.norm(log["push"], axis=-1).max())
            entries.append((PUSH_COLOUR, f"push, up to {largest:.0f} N"))
        return entries

    def arrows(self, step: int) -> list[Arrow]:
        """Return the forces of a step, and a push on the base, above it so that it can be seen."""
        arrows, push = log_arrows(self.log, step, self.terrain, self.scale), self.log["push"][step]
        if push.any():  # only a free base is pushed
            arrows.append((self.log["q"][step, :3] + self._above, 2.0 * self.scale * push, PUSH_COLOUR))
        return arrows

    def lines(self, step: int) -> list[Arrow]:
        """Return cones whose rims hold the forces' tips, and the ground's edges."""
        heights = self.scale * self.log["forces"][step][:, 2]
        cones = cone_lines(self.log, step, self.terrain, heights, RIM, 4)
        return [*cones, *self.edges]


def frames_of(
    log: Log, robot: Robot, terrain: Terrain, rate: float = RATE, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> Iterator[Any]:
    """Yield the pictures of a log, (height, width, 3), at `rate` frames per second of simulated time.

    Raises
    ------
    RenderError
        Before the first frame, if there is no OpenGL.
    """
    renderer = Renderer(robot, terrain, *size)
    try:
        dt = float(log.facts["dt"])
        every = 1.0 / (rate * dt)
        scene = FilmScene(log, terrain, ARROW_LENGTH * renderer.size / (robot.mass * GRAVITY), renderer.size)
        title = f"{robot.name}, ground of friction {float(log['mu'][0]):.2g}"
        overlay, facts = Overlay(*size, title, scene.legend()), film_facts(log, robot)
        for k in range(int(len(log) / every)):
            step = int(k * every)
            picture = renderer.frame(log["q"][step], scene.arrows(step), scene.lines(step), 1.0 / rate)
            yield overlay.over(picture, float(log["time"][step]), facts, step)
    finally:
        renderer.close()


def write_video(
    log: Log, robot: Robot, terrain: Terrain, path: Path, progress: Callable[[float], None] | None = None,
    height: int = HEIGHT,
) -> Path:  # fmt: skip
    """Write a film of a log as .mp4 and return its path; `progress` is called with the share done.

    `height` is that of its pictures [pixels], which are 16 to 9: 720 or 1080.

    Raises
    ------
    RenderError
        If there is no OpenGL, or the film cannot be written.
    MissingExtra
        If imageio with its ffmpeg is not installed.
    """
    with needs("imageio-ffmpeg", "sim"):
        import imageio.v2 as imageio
        import imageio_ffmpeg  # noqa: F401
    total = max(1, int(len(log) * float(log.facts["dt"]) * RATE))
    writer = None
    try:
        for k, picture in enumerate(frames_of(log, robot, terrain, size=(height * 16 // 9, height))):
            if writer is None:
                writer = imageio.get_writer(path, fps=RATE, quality=7, macro_block_size=8)
            writer.append_data(picture)
            if progress is not None:
                progress((k + 1) / total)
    except OSError as error:
        raise RenderError(f"no video: {error}") from error
    finally:
        if writer is not None:
            writer.close()
    return path


def write_animation(pictures: Sequence[Any], path: Path, rate: int) -> None:
    """Write pictures of Pillow as an endless .webp, so many a second; its folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    first, *rest = pictures
    first.save(
        path, save_all=True, append_images=rest, duration=round(1000 / rate), loop=0, quality=60, method=6
    )
