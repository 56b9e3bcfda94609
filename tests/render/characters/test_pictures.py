"""Pictures of characters: a body out of a file is the body; images, shadows, styles and far levels are seen."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from live.base.character import CharacterFile
from live.base.picture import of_group, picture_of
from live.base.stage_view import Camera
from live.render.quality import CARD, SOFTWARE
from live.render.renderer import Renderer
from tests.render.characters.figures import Figure, document, glb, glb_of, mixamo, painted
from tests.render.poses import ARMS_DOWN, LUNGE, REACH, stage_view
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (256, 144)
CAMERA = Camera(eye=(0.0, 1.6, 5.5), target=(0.0, 0.9, 0.0), field_of_view_deg=40.0)
OTHER = {"LowerLeg": 0.8, "Foot": 0.85, "UpperArm": 1.2, "LowerArm": 1.2, "Hand": 1.1, "head": 1.3}


def three():
    return stage_view([(LUNGE, (-1.5, 0.0), 20.0, 0), (ARMS_DOWN, (0.0, 0.3), 0.0, 1), (REACH, (1.5, 0.0), 0.0, 2)])


@pytest.fixture(scope="module")
def made(headless_context, tmp_path_factory):
    """Renderers by what they draw, kept for all tests of this file; a fresh scene to each."""
    kept, folder = {}, tmp_path_factory.mktemp("characters")

    def renderer(data, quality, bodies):
        key = data, quality, bodies
        if key not in kept:
            begin = scene(3, CAMERA)
            if data is not None:
                path = folder / f"anna{len(kept)}.glb"
                path.write_bytes(data)
                begin = replace(begin, characters=(CharacterFile("anna", str(path)),), bodies=bodies)
            kept[key] = Renderer(headless_context, begin, size=SIZE, quality=quality), begin
        return kept[key]

    yield renderer
    with headless_context:
        for one, _ in kept.values():
            one.release()


@pytest.fixture
def drawn(gl_context, made):
    """The picture of three dancers who all have the character of a file (None: the generated body)."""

    def once(data, quality=SOFTWARE, view=None, bodies=("anna",) * 3, **styles):
        renderer, begin = made(data, quality, bodies)
        target = gl_context.simple_framebuffer(SIZE)
        assert gl_context.error
        view = view or three()
        view.picture = picture_of(begin)
        for name, value in styles.items():
            for group in range(3):
                view.picture[of_group(f"/dance/draw/{name}", group).where] = value
        renderer.draw(view, target)
        assert gl_context.error == "GL_NO_ERROR"
        picture = read(target)
        target.release()
        return picture

    return once


def nobody():
    view = three()
    view.present[:] = False
    return view


def seen(picture, empty):
    """Pixels that show a dancer: others than without them, and not on the floor's shadows."""
    return np.abs(picture.astype(int) - empty).max(axis=2) > 24


@pytest.mark.parametrize("quality", [SOFTWARE, CARD], ids=["software", "card"])
def test_the_generated_body_out_of_a_file_has_its_outline(drawn, quality):
    level = quality.near_level
    white, red = {"silhouette": 1.0, "solid": 0.0}, "silhouette/colour"
    body = drawn(None, quality, **white, **{red: (1.0, 1.0, 1.0)})
    own = drawn(glb_of(level=level, names=mixamo), quality, **white, **{red: (1.0, 1.0, 1.0)})
    inside = body.min(axis=2) > 200
    assert inside.mean() > 0.015
    assert (inside != (own.min(axis=2) > 200)).sum() <= 0.01 * inside.sum()


@pytest.mark.parametrize("quality", [SOFTWARE, CARD], ids=["software", "card"])
def test_other_proportions_and_poses_are_drawn_where_the_dancer_is(drawn, quality):
    empty = drawn(None, quality, view=nobody())
    body = seen(drawn(None, quality), empty)
    own = seen(drawn(glb_of(names=mixamo, image=painted(), lengths=OTHER, arms_down=50.0), quality), empty)
    assert (body & own).sum() > 0.88 * max(body.sum(), own.sum())


def test_images_colour_it_and_holes_in_them_are_holes(drawn):
    red = drawn(glb_of(colour=(0.8, 0.0, 0.0, 1.0))).astype(int)
    assert ((red[..., 0] > red[..., 2] + 40) & (red[..., 0] > red[..., 1] + 40)).mean() > 0.02
    blue = drawn(glb_of(colour=(0.0, 0.0, 0.8, 1.0))).astype(int)
    assert (blue[..., 2] > blue[..., 0] + 60).mean() > 0.02
    out = io.BytesIO()
    Image.fromarray(np.full((4, 4, 4), (255, 255, 255, 0), np.uint8)).save(out, "PNG")
    root, chunk = document(Figure(image=out.getvalue()))
    root["materials"][0]["alphaMode"] = "MASK"
    empty, above = drawn(None, view=nobody()), slice(0, SIZE[1] // 2)  # where no shadow falls
    clear = seen(drawn(glb(root, chunk)), empty)[above]
    assert clear.mean() < 0.001 < 0.02 < seen(drawn(glb_of()), empty)[above].mean()


def test_it_looks_as_it_did(drawn, golden):
    data = glb_of(image=painted(128), names=mixamo, lengths=OTHER, arms_down=50.0, level=2, double=True)

    def law(picture):  # striped shirts: red and white between the heads and the legs
        chest = picture[45:90].astype(int)
        red = (chest[..., 0] > chest[..., 1] + 60) & (chest[..., 0] > chest[..., 2] + 60)
        return bool(red.mean() > 0.008 and (chest.min(axis=2) > 150).mean() > 0.004)

    golden(drawn(data), "character", law=law)
    golden(drawn(data, CARD), "character_card", law=law)


@pytest.mark.parametrize("style", ["ink", "particles", "xray", "trails", "ribbons"])
def test_all_styles_are_drawn_of_it(drawn, style):
    data = glb_of(image=painted())
    plain, styled = drawn(data), drawn(data, **{"solid": 0.0, style: 1.0})
    assert np.abs(plain.astype(int) - styled).mean() > 0.5


def test_one_character_beside_generated_bodies(drawn):
    view = three()
    view.group[:] = 1  # in blue
    picture = drawn(glb_of(colour=(0.9, 0.0, 0.0, 1.0)), view=view, bodies=("dancer", "anna", "dancer")).astype(int)
    red = (picture[..., 0] > 2 * picture[..., 1] + 30) & (picture[..., 0] > 2 * picture[..., 2] + 30)
    middle = slice(SIZE[0] // 2 - 30, SIZE[0] // 2 + 30)
    assert red[:, middle].sum() > 200
    assert red.sum() == red[:, middle].sum()
