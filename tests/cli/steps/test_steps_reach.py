"""`live steps show --reach`: the picture of the possible travel of one measure of a step."""

import io
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from live.app.offline.step_report import reach_of_step
from live.app.pictures.reach_picture import SIZE, TOP, PngCanvas, SvgCanvas, draw_reach, outline
from live.cli.main import app
from live.graph.select.reachability import DIRECTION_NAMES

SVG = "{http://www.w3.org/2000/svg}"


def run(*arguments):
    return CliRunner().invoke(app, ["steps", "show", *map(str, arguments)])


def test_svg_has_dot_for_each_clip_to_scale(tmp_path):
    file = tmp_path / "walk.svg"
    assert run("walk", "--reach", file).exit_code == 0
    root = ElementTree.parse(file).getroot()
    circles = [circle.attrib for circle in root.iter(f"{SVG}circle")]
    clips = [circle for circle in circles if float(circle["r"]) == 5.0]
    assert len(clips) == 18  # nine directions, both sides
    rings = sorted(float(circle["r"]) for circle in circles if circle["fill"] == "none")
    metre = rings[1]  # rings at 0.5 and 1 m
    assert rings[0] == pytest.approx(0.5 * metre, abs=0.1)
    ahead = min(float(circle["cy"]) for circle in clips)
    assert (TOP + SIZE / 2 - ahead) / metre == pytest.approx(1.1, abs=0.01)  # "long = 1.1" in walk.toml, ahead is up
    texts = [text.text for text in root.iter(f"{SVG}text")]
    assert any("walk" in text for text in texts)
    assert not set(texts) & set(DIRECTION_NAMES)


def test_left_is_drawn_on_left_and_missing_directions_are_named():
    """The grapevine travels to both sides, left and right only; all other directions are drawn as missing."""
    reach = reach_of_step("grapevine", None)
    assert set(reach.missing) == set(DIRECTION_NAMES) - {"to the left", "to the right"}
    canvas = SvgCanvas()
    draw_reach(reach, canvas)
    root = ElementTree.fromstring(canvas.data())
    texts = {text.text: float(text.attrib["x"]) for text in root.iter(f"{SVG}text")}
    assert texts["forward and to the left"] < SIZE / 2 < texts["forward and to the right"]
    assert set(texts) >= set(reach.missing)
    assert len([line for line in root.iter(f"{SVG}line") if "stroke-dasharray" in line.attrib]) == 6


def test_png_shows_same_picture_as_svg(tmp_path):
    file = tmp_path / "walk.png"
    assert run("walk", "--reach", file, "--json").exit_code == 0
    picture = Image.open(file)
    assert picture.size == (SIZE, SIZE + TOP)
    pixels = np.asarray(picture.convert("RGB")).astype(int)
    assert (np.abs(pixels - (0x1F, 0x4E, 0x8C)).sum(axis=2) < 30).sum() > 500
    canvas = PngCanvas()
    draw_reach(reach_of_step("walk", None), canvas)
    assert Image.open(io.BytesIO(canvas.data())).size == picture.size


def test_outline_is_farthest_travel_in_each_sector():
    ways = np.array([(0.0, 1.0), (0.0, 0.5), (2.0, 0.0), (0.0, -0.3)])
    points = outline(ways)
    assert len(points) == 72
    lengths = np.array([math.hypot(*point) for point in points])
    assert lengths[[0, 18, 36]] == pytest.approx([1.0, 2.0, 0.3])
    assert (np.delete(lengths, [0, 18, 36]) == 0.0).all()


@pytest.mark.parametrize(
    ("file", "told"), [("walk.pdf", ".svg or .png"), ("walk", ".svg or .png"), ("no/folder/walk.svg", "no folder")]
)
def test_unwritable_pictures_are_refused(tmp_path, file, told):
    result = run("walk", "--reach", tmp_path / file)
    assert result.exit_code != 0
    assert told in " ".join(str(result.exception or result.output).split())
    assert not (tmp_path / file).exists()


def test_unknown_step_is_refused_with_suggestion(tmp_path):
    result = run("wlak", "--reach", tmp_path / "a.svg")
    assert result.exit_code != 0
    assert "walk" in str(result.exception or result.output)
    assert list(tmp_path.iterdir()) == []
