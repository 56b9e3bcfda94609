"""SVG paths and files: sampled segments, group transforms and refusal of harmful files."""

import math

import numpy as np
import pytest

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from live.agents.formations.svg_import import path_lines, svg_file_paths
from live.base.errors import PersonError

SVG = '<svg xmlns="http://www.w3.org/2000/svg">{}</svg>'


def test_arc_segments_form_a_circle():
    (line,) = path_lines("M -2 0 A 2 2 0 0 1 2 0 A 2 2 0 0 1 -2 0 Z", "here")
    assert np.hypot(*line.T) == pytest.approx(np.full(len(line), 2.0))
    assert line[0] == pytest.approx(line[-1])
    assert np.hypot(*np.diff(line, axis=0).T).sum() == pytest.approx(4 * math.pi, rel=1e-3)


def test_cubic_segment_matches_bernstein_polynomial():
    (line,) = path_lines("M 0 0 C 0 3 4 3 4 0", "here")
    t = np.linspace(0, 1, 25)[:, None]
    control = np.array([[0, 0], [0, 3], [4, 3], [4, 0]])
    expected = sum(math.comb(3, k) * t**k * (1 - t) ** (3 - k) * control[k] for k in range(4))
    assert line == pytest.approx(expected)


def test_subpaths_become_separate_lines():
    lines = path_lines("M 0 0 L 1 0 M 5 5 L 6 5 L 6 6 Z", "here")
    assert [len(line) for line in lines] == [2, 4]


def test_down_in_the_drawing_points_to_the_audience():
    formation = formation_of(spec_from_table({"shape": "path", "path": "M 0 0 L 0 10"}), 3)
    assert formation.slots[0, 1] < formation.slots[2, 1]


def test_file_shapes_and_group_transforms_are_read():
    text = SVG.format(
        '<g transform="translate(10,0) scale(2)"><path d="M 0 0 L 1 0"/></g><circle cx="1" cy="1" r="1"/>'
    )
    second, first = sorted(svg_file_paths(text, "file"), key=len, reverse=True)
    (line,) = path_lines(first, "file")
    assert sorted(line[:, 0]) == pytest.approx([10.0, 12.0])
    (circle,) = path_lines(second, "file")
    assert np.hypot(*(circle - 1.0).T) == pytest.approx(np.ones(len(circle)), abs=1e-6)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not an SVG file"),
        ("<svg", "not an SVG file"),
        (SVG.format(""), "draws no line"),
        (SVG.format("<text>hello</text>"), "draws no line"),
        ('<!DOCTYPE svg [<!ENTITY a "aaaa">]>' + SVG.format("<path d='M 0 0 L 1 1'/>"), "entities"),
        (SVG.format("<path d='M 0 0 Q'/>"), ""),
        ("x" * 2_000_001, "larger"),
    ],
)
def test_invalid_svg_file_is_refused(text, words):
    with pytest.raises(PersonError) as refused:
        svg_file_paths(text, "drawn.svg")
    assert words in str(refused.value)
    assert "drawn.svg" in str(refused.value)
