"""Colours that stand side by side differ for every eye, and are all in one file."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import surefoot
from surefoot.app.viz import palette

EYES = {
    "all": np.eye(3),
    "no red": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "no green": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "no blue": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
"""Linear colours as seen by each eye: Machado, Oliveira and Fernandes (2009), table 1, severity 1."""
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
WHITE = np.array([0.95047, 1.0, 1.08883])
SIDE_BY_SIDE = {
    "verdicts": ((palette.GOOD, palette.WARN, palette.BAD), 20.0),
    "space": ((palette.FORCE, palette.CONE, palette.PUSH, palette.MOTION, palette.GOOD), 14.0),
    "feet": (palette.LINES[:4], 25.0),
    "curves": (palette.LINES, 16.0),
    "pyramids": ((palette.LINES[0], palette.LINES[2], palette.BAD), 20.0),
}
"""Colours, and the least distance of any two. Two that differ by 10 are told apart at a glance."""


def linear(colour: str) -> np.ndarray:
    share = np.array(palette.rgb(colour)) / 255.0
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def lab(colour: str, eye: str) -> np.ndarray:
    """Return a colour in CIELAB as an eye sees it."""
    seen = TO_XYZ @ np.clip(EYES[eye] @ linear(colour), 0.0, 1.0) / WHITE
    f = np.where(seen > 216 / 24389, np.cbrt(seen), (24389 / 27 * seen + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def contrast(colour: str) -> float:
    """Return the contrast to white as the web's guidelines have it."""
    return 1.05 / (float((TO_XYZ @ linear(colour))[1]) + 0.05)


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("what", SIDE_BY_SIDE)
def test_colours_side_by_side_differ_for_every_eye(what: str, eye: str) -> None:
    colours, least = SIDE_BY_SIDE[what]
    for one, other in combinations(colours, 2):
        distance = float(np.linalg.norm(lab(one, eye) - lab(other, eye)))
        assert distance >= least, f"{one} and {other}: {distance:.1f}"


def test_text_and_curves_stand_out_from_paper() -> None:
    for colour in (palette.INK, palette.NOTE, palette.GOOD, palette.BAD):
        assert contrast(colour) >= 4.5  # text
    assert all(contrast(colour) >= 2.0 for colour in palette.LINES)
    assert all(contrast(colour) >= 3.0 for colour in palette.LINES[:3])


def test_the_old_red_and_green_would_have_been_found() -> None:
    """The feet were drawn in these, which one man in sixteen takes for one colour."""
    assert np.linalg.norm(lab("#d1495b", "no green") - lab("#2e933c", "no green")) < 10.0


def test_no_other_file_of_the_app_has_colours_of_its_own() -> None:
    app = Path(surefoot.__file__).parent / "app"
    found = {
        path.relative_to(app).as_posix()
        for path in app.rglob("*.py")
        if re.search(r"[\"' ]#[0-9a-fA-F]{6}\b", path.read_text(encoding="utf-8"))
    }
    assert found == {"viz/palette.py"}


def test_colours_as_numbers() -> None:
    assert palette.rgb("#0080ff") == (0, 128, 255)
    assert palette.rgba("#ff0080", 0.5) == (1.0, 0.0, 0.502, 0.5)
    assert palette.blend("#102030", "#102030", 0.3) == "#102030"
    assert palette.blend("#000000", "#ff0000", 2.0) == "#ff0000"
