"""Set pieces from glTF files: place and size, light and images, hiding by depth, fading, shadows, refused files."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import SceneryFile
from live.motion.formats.file_error import MotionFileError
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.media.set_model import SOFTWARE_TRIANGLES, place_on_stage, read_set_model
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.media import lathe, write_glb
from tests.render.test_renderer import SIZE, read, scene, standing

SLAB = {
    "position": [(-1, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0)], "normal": [(0, 0, 1)] * 4,
    "triangle": [(0, 1, 2), (0, 2, 3)], "uv": [(0, 1), (1, 1), (1, 0), (0, 0)], "material": 0,
}  # fmt: skip
RED = {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.02, 0.02, 1.0]}}
BOTH = mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])


@pytest.fixture
def draw(gl_context):
    """Draws one dancer in the middle with set pieces."""

    def once(*pieces, quality=SOFTWARE, amount=1.0):
        of = replace(scene(1), scenery=pieces)
        renderer = Renderer(gl_context, of, size=SIZE, quality=quality)
        target = gl_context.simple_framebuffer(SIZE)
        view = standing()
        view.picture = picture_row(of)
        for number in range(len(pieces)):
            view.picture[BY_ADDRESS[f"/dance/scenery/{number + 1}"].first] = amount
        renderer.draw(view, target)
        seen, problems = read(target).astype(int), renderer.problems
        renderer.release()
        target.release()
        return seen, problems

    return once


def pixel(*at):
    return project_points(scene(1).camera, SIZE, [at])[0].astype(int)


@pytest.mark.gl
@BOTH
def test_set_piece_and_dancer_hide_each_other_by_depth_and_amount_fades(draw, tmp_path, quality):
    file = str(write_glb(tmp_path / "slab.glb", [SLAB], materials=[RED]))
    bare, _ = draw(quality=quality)
    before, _ = draw(SceneryFile(file, (0.0, 1.5)), quality=quality)
    behind, problems = draw(SceneryFile(file, (0.0, -1.5)), quality=quality)
    none, _ = draw(SceneryFile(file, (0.0, 1.5)), quality=quality, amount=0.0)
    assert problems == []
    assert np.array_equal(none, bare)
    x, y = pixel(0.0, 1.2, 0.1)
    assert before[y, x, 0] > 60 > 2 * before[y, x, 1]
    assert np.abs(behind[y, x] - bare[y, x]).max() < 12
    x, y = pixel(0.6, 1.2, -1.5)
    assert behind[y, x, 0] > 60 > 2 * behind[y, x, 1]


@pytest.mark.long
@pytest.mark.gl
def test_half_faded_set_piece_shows_half_of_its_pixels(draw, tmp_path):
    file = str(write_glb(tmp_path / "slab.glb", [SLAB], materials=[RED]))
    said = SceneryFile(file, (0.0, -1.5), scale=1.5)
    red = {amount: (seen := draw(said, amount=amount)[0])[..., 0] - seen[..., 1] for amount in (0.0, 0.5, 1.0)}
    whole = (red[1.0] > 40) & (red[0.0] < 10)
    assert whole.sum() > 1000
    assert (
        0.3 < red[0.5][whole].mean() / red[1.0][whole].mean() < 0.65
    )  # edges of pixels are smoothed, displayed values


@pytest.mark.gl
@BOTH
def test_image_of_a_set_piece_is_upright(draw, tmp_path, quality):
    pixels = np.zeros((16, 16, 3), np.uint8)
    pixels[:8], pixels[8:] = (20, 200, 30), (200, 20, 30)  # green above
    content = io.BytesIO()
    Image.fromarray(pixels).save(content, "PNG")
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    file = str(write_glb(tmp_path / "a.glb", [SLAB], materials=[material], images=[content.getvalue()]))
    seen, _ = draw(SceneryFile(file, (2.5, 0.0)), quality=quality)
    above, below = (seen[y, x] for x, y in (pixel(2.5, 1.6, 0.0), pixel(2.5, 0.4, 0.0)))
    assert above[1] > above[0] + 30
    assert below[0] > below[1] + 30


@pytest.mark.long
@pytest.mark.gl
def test_set_piece_casts_a_shadow_away_from_the_key_light(draw, tmp_path):
    post = lathe([(0.4, 0.0), (0.4, 1.0), (0.001, 1.0)])
    file = str(write_glb(tmp_path / "post.glb", [post]))
    (bare, _), (seen, _) = draw(), draw(SceneryFile(file, (2.0, 0.0)))
    towards = np.array(BY_ADDRESS["/dance/light/key/direction"].start)
    x, z = towards[[0, 2]] / abs(towards[1])
    at = pixel(2.0 + 0.85 * x - 0.15, 0.0, 0.85 * z)
    other = pixel(2.0 - 0.9 * x + 0.3, 0.0, 0.3 - 0.9 * z)
    assert seen[at[1], at[0]].sum() < 0.85 * bare[at[1], at[0]].sum()
    assert seen[other[1], other[0]].sum() > 0.95 * bare[other[1], other[0]].sum()


@pytest.mark.long
@pytest.mark.gl
def test_file_lost_after_the_check_is_left_out_and_told(draw, tmp_path):
    (bare, _), (seen, problems) = draw(), draw(SceneryFile(str(tmp_path / "gone.glb")))
    assert np.array_equal(seen, bare)
    assert problems == ["scenery gone.glb: there is no such file; it is left out"]


def test_set_piece_stands_on_its_underside_turned_and_scaled(tmp_path):
    shifted = SLAB | {"translation": (5.0, 3.0, -2.0), "scale": (1.0, 2.0, 1.0)}
    model = read_set_model(write_glb(tmp_path / "slab.glb", [shifted], materials=[RED]))
    assert model.height == pytest.approx(4.0)
    said = SceneryFile("", at=(1.0, -2.0), turn_deg=90.0, lift=0.5, height=2.0)
    position, normal, _ = place_on_stage(model, said)
    assert position[:, 1].min() == pytest.approx(0.5)
    assert position[:, 1].max() == pytest.approx(2.5)
    assert position[:, 0] == pytest.approx(np.full(4, 1.0), abs=1e-6)  # a quarter turn: it is as wide along z
    assert np.ptp(position[:, 2]) == pytest.approx(1.0)
    assert normal == pytest.approx(np.tile((1.0, 0.0, 0.0), (4, 1)), abs=1e-6)  # turned as a dancer: to +x


def ball(sides):
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides // 2)
    return lathe(np.column_stack([np.maximum(np.cos(angle), 1e-3), np.sin(angle)]), sides)


@pytest.mark.long
def test_large_set_piece_is_simplified_for_software_and_keeps_its_shape(tmp_path):
    model = read_set_model(write_glb(tmp_path / "ball.glb", [ball(300) | {"material": 0}], materials=[RED]))
    assert len(model.triangle) > 2 * SOFTWARE_TRIANGLES
    light = model.simplified(SOFTWARE_TRIANGLES)
    assert 0.25 * SOFTWARE_TRIANGLES < len(light.triangle) <= SOFTWARE_TRIANGLES
    distance = np.linalg.norm(light.position - (0.0, 1.0, 0.0), axis=1)
    assert distance.min() > 0.97
    assert np.linalg.norm(light.normal, axis=1) == pytest.approx(np.ones(len(light.normal)))
    assert model.simplified(10**9) is model


@pytest.mark.long
def test_three_million_triangles_are_refused_with_a_remedy(tmp_path):
    row = np.arange(1000)
    position = np.zeros((1000, 3), "f4")
    position[:, 0] = row
    triangle = np.random.default_rng(1).integers(0, 1000, (3_000_000, 3))
    path = write_glb(tmp_path / "huge.glb", [{"position": position, "triangle": triangle}])
    with pytest.raises(MotionFileError, match=r"3,000,000 triangles; 300,000 at most.*Decimate"):
        read_set_model(path)


def test_files_without_triangles_or_extent_are_refused(tmp_path):
    point = {"position": [(0, 0, 0)] * 3, "triangle": [(0, 1, 2)]}
    with pytest.raises(MotionFileError, match="no extent"):
        read_set_model(write_glb(tmp_path / "point.glb", [point]))
    with pytest.raises(MotionFileError, match="no such file"):
        read_set_model(tmp_path / "none.glb")
    (tmp_path / "words.glb").write_bytes(b"words")
    with pytest.raises(MotionFileError):
        read_set_model(tmp_path / "words.glb")
