"""Parts of the picture: what outputs need of it, drawn alone as in the whole picture."""

import math
from dataclasses import replace

import moderngl
import numpy as np
import pytest

from live.base.custom_pass import parse_custom_pass
from live.base.picture_parameters import BY_ADDRESS, CUSTOM_PASS_SLICE, picture_row
from live.base.stage_snapshot import Title
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import PicturePart, world_to_clip
from live.render.headless import OffscreenTarget
from live.render.outputs.output import Output, SoftEdge
from live.render.outputs.output_pass import OutputPass
from live.render.outputs.picture_layout import (
    GRID,
    MAX_SIDE,
    PASS_REACH,
    drawn_part,
    picture_reach,
    whole_picture_reason,
)
from live.render.passes.custom_pass import reads_elsewhere
from live.render.pipeline import PICTURE_PASSES
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.passes.test_passes import SCENE, three_dancers

SIZE = (576, 288)
HALVES = tuple(Output(name, crop=(left, 0.0, 0.5, 1.0)) for name, left in (("left", 0.0), ("right", 0.5)))
QUARTERS = tuple(Output(f"{x} {y}", crop=(x, y, 0.5, 0.5)) for x in (0.0, 0.5) for y in (0.0, 0.5))
PLAIN = replace(SCENE, passes=("shadow", "mirror", "vignette"))


def near(reach):
    return lambda height: reach


def difference(one, other):
    return np.abs(one.astype(int) - other.astype(int)).max(axis=2)


@pytest.fixture
def draw(gl_context):
    """Draws frames with a renderer of its own for a whole picture or a part; returns the last one, top row first."""
    kept = []

    def drawn(scene, size, *views, quality=SOFTWARE, **values):
        renderer = Renderer(gl_context, scene, size=size, quality=quality, warm_up=False)
        target = OffscreenTarget(gl_context, renderer.size)
        kept.extend((renderer, target))
        row = picture_row(scene)
        for address, value in values.items():
            row[BY_ADDRESS[f"/dance/{address.replace('_', '/')}"].row_slice] = value
        row[CUSTOM_PASS_SLICE.start] = 1.0 if scene.custom_passes else 0.0
        for number, view in enumerate(views or (three_dancers(),)):
            view.picture, view.time, view.beat = row, number / 60.0, number / 30.0
            renderer.draw(view, target.framebuffer)
        return target.read().copy()

    yield drawn
    for thing in kept:
        thing.release()


def joined(draw, scene, outputs, reach, *views, **how):
    """The crops of `outputs`, each drawn alone in the part with that border, put together."""
    picture = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    for output in outputs:
        part = drawn_part([output], [(1, 1)], near(reach), asked=SIZE)
        assert not part.is_whole
        seen = draw(scene, part, *views, **how)
        x, y, width, height = (round(share * side) for share, side in zip(output.crop, SIZE * 2, strict=True))
        left, top = part.left, SIZE[1] - part.bottom - part.size[1]
        picture[y : y + height, x : x + width] = seen[y - top : y - top + height, x - left : x - left + width]
    return picture


# -- which part --------------------------------------------------------------------------------------------------


def test_part_holds_its_crops_with_border_and_lies_on_the_grid():
    chance = np.random.default_rng(5)
    for _ in range(200):
        whole = tuple(chance.integers(400, 9000, 2).tolist())
        low, high = np.sort(chance.uniform(0.0, 1.0, (2, 2)), axis=0)
        output, reach = Output(crop=(*low, *np.maximum(high - low, 1e-3))), float(chance.uniform(0.0, 300.0))
        part = drawn_part([output], [(1, 1)], near(reach), asked=whole)
        start, end = np.array([part.left, part.bottom]), np.array([part.left, part.bottom]) + part.size
        if part.is_whole:
            continue
        x, y, width, height = output.crop
        first = np.array([x, 1.0 - y - height]) * part.whole - reach
        last = np.array([x + width, 1.0 - y]) * part.whole + reach
        assert (start <= np.maximum(first, 0.0) + 1e-6).all()
        assert (end >= np.minimum(last, part.whole) - 1e-6).all()
        assert (start % GRID == 0).all()
        assert ((end % GRID == 0) | (end == part.whole)).all()


def test_several_outputs_get_the_rectangle_around_them_and_nearly_all_is_all():
    corner = drawn_part([QUARTERS[0], HALVES[0]], [(288, 144), (288, 288)], near(10.0), asked=SIZE)
    assert (corner.left, corner.bottom, corner.size) == (0, 0, (384, 288))
    assert drawn_part(HALVES, [(288, 288)] * 2, near(0.0)).is_whole
    assert drawn_part([HALVES[0]], [(288, 288)], near(math.inf), asked=SIZE) == PicturePart.of(SIZE)
    assert drawn_part([HALVES[0]], [(288, 288)], near(280.0), asked=SIZE).is_whole  # the border leaves nothing to save


def test_picture_may_be_larger_than_what_is_drawn_at_once():
    eighth = Output(crop=(0.25, 0.0, 0.125, 1.0))
    part = drawn_part([eighth], [(1920, 1080)], near(100.0))
    assert part.whole == (15360, 1080)  # every pixel of the projector is drawn
    assert part.size[0] < 2400
    assert part.left <= 3840 - 100
    wide = drawn_part([Output(crop=(0.0, 0.0, 0.5, 1.0))], [(1, 1)], near(100.0), asked=(60_000, 3000))
    assert not wide.is_whole
    assert max(wide.size) <= MAX_SIDE
    assert wide.whole[0] / wide.whole[1] == pytest.approx(20.0, rel=2e-3)


def test_every_pass_says_how_far_it_looks():
    assert set(PICTURE_PASSES) <= set(PASS_REACH)
    row = picture_row(SCENE)
    assert 0.0 < picture_reach(SCENE, 1080.0, row) < 400.0
    assert picture_reach(PLAIN, 1080.0, row) < 0.5 * picture_reach(SCENE, 1080.0, row)


def test_growing_trails_need_the_whole_picture():
    row = picture_row(SCENE)
    row[BY_ADDRESS["/dance/pass/trails"].first] = 0.5
    assert math.isfinite(picture_reach(SCENE, 1080.0, row))
    row[BY_ADDRESS["/dance/pass/trails/zoom"].first] = 0.2
    assert "trails" in whole_picture_reason(SCENE, row)
    assert math.isinf(picture_reach(SCENE, 1080.0, row))
    assert whole_picture_reason(PLAIN, row) == ""


@pytest.mark.parametrize(
    ("text", "elsewhere"),
    [
        ("vec4 pass(vec2 at) { return vec4(light(at) * length(at - 0.5), 1.0); }", False),
        ("vec4 pass(vec2 at) { return vec4(last( at ), 1.0); }  // light(at + 0.1)", False),
        ("vec4 pass(vec2 at) { return vec4(light(at + 0.01), 1.0); }", True),
        ("vec4 pass(vec2 at) { at.y += 0.1; return vec4(light(at), 1.0); }", True),
        ("vec4 pass(vec2 at) { at = 1.0 - at; return vec4(light(at), 1.0); }", True),
        ("vec3 get(vec2 at) { return light(at); }\nvec4 pass(vec2 at) { return vec4(get(at * 0.5), 1.0); }", True),
        ("#define at (0.5 * at)\nvec4 pass(vec2 at) { return vec4(light(at), 1.0); }", True),
        ("vec4 pass(vec2 at) { return vec4(float(dancer(at.yx)), 0.0, 0.0, 1.0); }", True),
    ],
)
def test_custom_passes_that_look_elsewhere_need_the_whole_picture(text, elsewhere):
    own = parse_custom_pass("mine", text)
    assert reads_elsewhere(own) == elsewhere
    scene = replace(PLAIN, custom_passes=(own,), passes=(*PLAIN.passes, "mine"))
    assert ("mine" in whole_picture_reason(scene, picture_row(scene))) == elsewhere


# -- the same picture --------------------------------------------------------------------------------------------


def test_whole_picture_is_a_part_without_any_change():
    camera = SCENE.camera
    part = PicturePart(SIZE, 96, 0, (192, 288))
    np.testing.assert_array_equal(world_to_clip(camera, PicturePart.of(SIZE)), world_to_clip(camera, SIZE))
    point = np.array([0.3, 1.0, 0.5, 1.0])
    whole, own = (world_to_clip(camera, each) @ point for each in (SIZE, part))
    pixel, inside = ((clip[0] / clip[3] + 1.0) * 0.5 * width for clip, width in ((whole, SIZE[0]), (own, 192)))
    assert inside == pytest.approx(pixel - 96.0, abs=1e-9)


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[1], ids=["software", "card"])
def test_parts_drawn_alone_are_the_whole_picture(draw, quality):
    view = three_dancers()
    view.titles = (Title("Both sides", progress=1.0),)
    view.caption, view.caption_level, view.overlay = (("Samba", 0.6), ("Groove", 0.4)), 1.0, ("measure 3",)
    view.guide_count, view.guide[0] = 1, (-3.0, 0.0, 1.0, 3.0, 2.0, 1.0, 1.0, 0.5, 0.0, 1.0)
    whole = draw(PLAIN, SIZE, view, quality=quality)
    parts = joined(draw, PLAIN, QUARTERS, 12.0, view, quality=quality)
    off = difference(whole, parts)
    assert whole[: SIZE[1] // 2].std() > 10.0
    assert (off == 0).mean() > 0.998  # matrices are rounded to single precision: an edge may fall beside
    assert (off > 1).mean() < 5e-4


@mostly_long("name", ["bloom", "ink", "trails", "focus", "blur"], quick=[])
def test_passes_find_in_the_border_what_they_need(draw, name):
    scene = replace(SCENE, passes=("shadow", "mirror", name))
    views = [three_dancers() for _ in range(3)]
    for number, view in enumerate(views):
        view.joint_position[:] += (0.03 * number, 0.0, 0.0)
    how = {"quality": HARDWARE, f"pass_{name}": 1.0}
    reach = picture_reach(scene, SIZE[1], picture_row(scene))
    whole, parts = draw(scene, SIZE, *views, **how), joined(draw, scene, HALVES, reach, *views, **how)
    off = difference(whole, parts)
    without = draw(scene, SIZE, *views, **{**how, f"pass_{name}": 0.0})
    assert difference(whole, without).mean() > 0.02  # the pass does something
    assert (off > 2).mean() < 0.01
    assert off[:, 280:296].mean() < 0.3  # beside the seam as elsewhere


@pytest.mark.long
def test_custom_pass_and_vignette_know_the_place_in_the_whole_picture(draw):
    text = "vec4 pass(vec2 at) { return vec4(light(at) * step(fract(at.x * 7.0), 0.5), 1.0); }"
    own = parse_custom_pass("mine", text)
    scene = replace(PLAIN, custom_passes=(own,), passes=("mine", "vignette", "grade"))
    how = {"pass_vignette": 1.0, "pass_grade": 1.0, "pass_grade_contrast": 1.1}
    whole, parts = draw(scene, SIZE, **how), joined(draw, scene, HALVES, 12.0, **how)
    assert (difference(whole, parts) > 1).mean() < 1e-3
    assert (difference(whole, draw(PLAIN, SIZE)) > 8).mean() > 0.2


def test_output_throws_the_same_from_a_part(gl_context: moderngl.Context):
    chance = np.random.default_rng(2)
    picture = chance.integers(0, 255, (SIZE[1], SIZE[0], 3), np.uint8)
    bent = ((0.1, 0.12), (0.93, 0.04), (0.86, 0.95), (0.05, 0.85))
    output = Output(crop=(0.5, 0.0, 0.5, 1.0), corners=bent, edge=SoftEdge(left=0.2))
    part = drawn_part([output], [(1, 1)], near(4.0), asked=SIZE)
    cut = picture[:, part.left :]
    seen = []
    for data, held in ((picture, None), (cut, part)):
        texture = gl_context.texture((data.shape[1], data.shape[0]), 3, data[::-1].tobytes(), alignment=1)
        texture.repeat_x = texture.repeat_y = False
        target, thrown = OffscreenTarget(gl_context, (320, 180)), OutputPass(gl_context, output)
        for card in ("off", "grid"):
            thrown.draw(texture, target.framebuffer, card=card, tick=128, part=held)
            seen.append(target.read().copy())
        for thing in (thrown, target, texture):
            thing.release()
    for whole, own in zip(seen[:2], seen[2:], strict=True):
        assert difference(whole, own).max() <= 1
    assert difference(seen[0], seen[1]).mean() > 20
