"""`[[output]]` of a venue: all keys, defaults, and errors with their line."""

from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.render.outputs.output import Output, SoftEdge
from live.show.patch.toml_model import parse_model
from live.show.venue.venue import Venue, read_venue


def venue(text: str) -> Venue:
    return parse_model(f'name = "hall"\n{text}', "hall.toml", Venue, "venue")


def test_output_with_all_keys_is_read():
    (one,) = venue("""
[[output]]
name = "left"
monitor = "right of primary"
crop = [0, 0, 0.55, 1]
corners = [[0.1, 0], [1, 0.05], [0.95, 1], [0, 0.9]]
mesh = [[[0, 0], [1, 0]], [[0, 1], [1, 1.02]]]
rotation = 180
mirror = true
soft_edge = { right = 0.2, gamma = 2.4, black = 0.01 }
mask = "masks/left.png"
brightness = 0.8
gamma = 1.1
""").output
    assert one.output(Path("/venues")) == Output(
        "left", "right of primary", (0, 0, 0.55, 1), ((0.1, 0), (1, 0.05), (0.95, 1), (0, 0.9)),
        (((0, 0), (1, 0)), ((0, 1), (1, 1.02))), 180, True, SoftEdge(right=0.2, gamma=2.4, black=0.01),
        Path("/venues/masks/left.png"), 0.8, 1.1,
    )  # fmt: skip


def test_output_without_keys_is_plain():
    assert venue("[[output]]").output[0].output(Path()).is_plain
    assert venue("").output == ()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("corners = [[0, 0], [0, 0], [0, 0], [0, 0]]", r"line 3: output.1.corners: the corners enclose nothing"),
        ("corners = [[0, 0], [1, 1], [1, 0], [0, 1]]", "the corners cross"),
        ("corners = [[0, 0], [1, 0], [1, 1]]", "output.1.corners"),
        ("corners = [[0, 0], [nan, 0], [1, 1], [0, 1]]", "output.1.corners.2.1"),
        ("mesh = [[[0, 0], [1, 0]], [[0, 1]]]", "different numbers of points"),
        ("mesh = [[[0, 0], [1, 0]], [[1, 1], [0, 1]]]", "folds over at row 1, column 1"),
        ("crop = [0.5, 0, 0.6, 1]", "output.1.crop: x, y, width, height"),
        ("crop = [0, 0, 0, 1]", "output.1.crop"),
        ('mask = "../secret.png"', "a file in the venue's folder"),
        ('mask = "/etc/passwd"', "a file in the venue's folder"),
        ("rotation = 45", "0, 90, 180 or 270, found 45"),
        ("soft_edge = { left = 0.2, rigt = 0.2 }", "did you mean 'right'"),
        ("soft_edge = { left = 0.7 }", "output.1.soft_edge.left"),
        ("brightness = 2", "output.1.brightness"),
        ('name = "*"', "not \\* alone"),
        ('node = "on the left"', r"output\.1\.node"),
        ('name = "A"\n[[output]]\nname = "a"', "line 5: output.2.name: another output has the name 'a'"),
    ],
)
def test_invalid_output_key_is_refused_with_its_line(text, words):
    with pytest.raises(PersonError, match=words):
        venue(f"[[output]]\n{text}")


def test_whole_picture_may_be_larger_than_a_texture():
    assert venue("picture_size = [15360, 1080]").picture_size == (15360, 1080)
    with pytest.raises(PersonError, match="picture_size"):
        venue("picture_size = [99999, 1080]")


def test_more_than_eight_outputs_are_refused():
    nine = [f'[[output]]\nname = "{n}"\n' for n in range(9)]
    with pytest.raises(PersonError, match=r"output\.9\.node: 9 outputs of the machine that plays the show; at most 8"):
        venue("".join(nine))
    with pytest.raises(PersonError, match=r"output\.9\.node: 9 outputs of node 'left'; at most 8"):
        venue("".join(f'{each}node = "left"\n' for each in nine))
    shared = venue("".join(f'{each}node = "node-{n // 3}"\n' for n, each in enumerate(nine)))
    assert [one.node for one in shared.output] == [f"node-{n // 3}" for n in range(9)]


def test_project_venue_has_matching_soft_edges():
    left, right = (one.output(Path()) for one in read_venue("two_projectors").output)
    assert left.crop[2] - right.crop[0] == pytest.approx(0.1)  # what both show
    assert left.edge.right * left.crop[2] == pytest.approx(0.1, abs=1e-3)
    assert right.edge.left * right.crop[2] == pytest.approx(0.1, abs=1e-3)
