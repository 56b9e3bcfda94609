"""The stroke font: every letter is recognised, in ink and by dancers who stand on it."""

from functools import cache

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial import cKDTree

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from live.agents.formations.stroke_font import STROKES, letter_strokes, text_strokes

LETTERS = [letter for letter in STROKES if letter.isalnum()]


@cache
def printed(letter):
    """Ink of the letter in an ordinary font, (n, 2), in a box of height 1."""
    picture = Image.new("L", (300, 300))
    ImageDraw.Draw(picture).text((80, 40), letter, fill=255, font=ImageFont.load_default(180))
    z, x = np.nonzero(np.asarray(picture) > 128)
    return boxed(np.stack([x, z], axis=1).astype(float)[::7])


def boxed(points):
    """Middle at (0, 0), height 1; letters keep their widths."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (points - (low + high) / 2) / (high[1] - low[1])


def likeness(points, letter):
    """Mean distance of dancers to ink, and of ink to dancers: 0 is the same (chamfer distance)."""
    ink = printed(letter)
    return cKDTree(ink).query(points)[0].mean() + cKDTree(points).query(ink)[0].mean()


def standing(letter, dancers):
    return boxed(formation_of(spec_from_table({"shape": "text", "text": letter, "size": [9, 6]}), dancers).slots)


def test_letters_are_those_of_an_ordinary_font():
    """Read by likeness to printed letters: nearly all at once, and the right one is never far from the first."""
    read = {}
    for letter in LETTERS:
        points = standing(letter, 26)
        read[letter] = sorted(LETTERS, key=lambda other: likeness(points, other))
    first = [letter for letter in LETTERS if read[letter][0] == letter]
    assert len(first) >= 30, {letter: read[letter][:3] for letter in LETTERS if read[letter][0] != letter}
    assert all(letter in read[letter][:4] for letter in LETTERS)


@pytest.mark.parametrize("letter", LETTERS)
def test_dancers_cover_all_strokes(letter):
    """Nowhere on the strokes is the next dancer farther than a gap and a half."""
    formation = formation_of(spec_from_table({"shape": "text", "text": letter, "size": [6, 6]}), 16)
    drawn = np.concatenate(
        [np.stack([np.interp(np.linspace(0, len(line) - 1, 400), np.arange(len(line)), line[:, k]) for k in (0, 1)], 1)
         for line in formation.lines]
    )  # fmt: skip
    length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in formation.lines)
    assert cKDTree(formation.slots).query(drawn)[0].max() < 1.0 * length / 15
    assert formation.min_distance > 0.35 * length / 16


def test_texts_are_read_from_left_to_right_by_the_public():
    strokes = text_strokes("LIVE ON")
    starts = [points[:, 0].min() for points, _ in strokes]
    assert starts[0] == 0.0
    assert max(starts) > 15
    ell, _ = letter_strokes("L")[0]
    assert ell[:, 1].tolist() == [0.0, 6.0, 6.0]  # its foot is nearest to the public
    assert formation_of(spec_from_table({"shape": "text", "text": "live"}), 24).slots == pytest.approx(
        formation_of(spec_from_table({"shape": "text", "text": "LIVE"}), 24).slots
    )


def test_an_unknown_letter_is_named():
    with pytest.raises(KeyError, match="!"):
        text_strokes("GO!")
