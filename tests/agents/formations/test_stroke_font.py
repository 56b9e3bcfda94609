"""The stroke font: every letter is legible, as strokes and as places of dancers."""

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
def letter_ink(letter):
    """Ink of the letter in an ordinary font, (n, 2), in a box of height 1."""
    picture = Image.new("L", (300, 300))
    ImageDraw.Draw(picture).text((80, 40), letter, fill=255, font=ImageFont.load_default(180))
    z, x = np.nonzero(np.asarray(picture) > 128)
    return normalize_height(np.stack([x, z], axis=1).astype(float)[::7])


def normalize_height(points):
    """Points centered at (0, 0) with height 1; the aspect ratio of a letter is kept."""
    low, high = points.min(axis=0), points.max(axis=0)
    return (points - (low + high) / 2) / (high[1] - low[1])


def chamfer_distance(points, letter):
    """Chamfer distance: mean distance of dancers to ink plus ink to dancers; 0 means identical."""
    ink = letter_ink(letter)
    return cKDTree(ink).query(points)[0].mean() + cKDTree(points).query(ink)[0].mean()


def dancer_points(letter, dancers):
    return normalize_height(
        formation_of(spec_from_table({"shape": "text", "text": letter, "size": [9, 6]}), dancers).slots
    )


@pytest.mark.long
def test_letters_resemble_a_printed_font():
    """By chamfer distance to printed letters: at least 30 rank first, all rank in the first four."""
    read = {}
    for letter in LETTERS:
        points = dancer_points(letter, 26)
        read[letter] = sorted(LETTERS, key=lambda other: chamfer_distance(points, other))
    first = [letter for letter in LETTERS if read[letter][0] == letter]
    assert len(first) >= 30, {letter: read[letter][:3] for letter in LETTERS if read[letter][0] != letter}
    assert all(letter in read[letter][:4] for letter in LETTERS)


@pytest.mark.parametrize("letter", LETTERS)
def test_dancers_cover_all_strokes_of_a_letter(letter):
    """Every point on the strokes is within one mean gap of a dancer."""
    formation = formation_of(spec_from_table({"shape": "text", "text": letter, "size": [6, 6]}), 16)
    drawn = np.concatenate(
        [np.stack([np.interp(np.linspace(0, len(line) - 1, 400), np.arange(len(line)), line[:, k]) for k in (0, 1)], 1)
         for line in formation.lines]
    )  # fmt: skip
    length = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in formation.lines)
    assert cKDTree(formation.slots).query(drawn)[0].max() < 1.0 * length / 15
    assert formation.min_distance > 0.35 * length / 16


def test_text_reads_left_to_right_for_the_audience():
    strokes = text_strokes("LIVE ON")
    starts = [points[:, 0].min() for points, _ in strokes]
    assert starts[0] == 0.0
    assert max(starts) > 15
    ell, _ = letter_strokes("L")[0]
    assert ell[:, 1].tolist() == [0.0, 6.0, 6.0]  # its foot is nearest to the public
    assert formation_of(spec_from_table({"shape": "text", "text": "live"}), 24).slots == pytest.approx(
        formation_of(spec_from_table({"shape": "text", "text": "LIVE"}), 24).slots
    )


def test_error_names_the_unknown_letter():
    with pytest.raises(KeyError, match="!"):
        text_strokes("GO!")
