"""Pictures of characters from files: outlines, images, materials, styles, normals and emission."""

import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from live.base.body.catalogue import CharacterFile
from live.base.picture_parameters import BY_ADDRESS, group_parameter, picture_row
from live.base.stage_snapshot import Camera
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.characters.character import load_character
from live.render.characters.materials import LEFT_OUT_NOTE, layers_of
from live.render.characters.model import Material
from live.render.characters.model_reader import parse_model
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.characters.figures import Figure, document, glb, glb_of, mixamo, striped_image
from tests.render.poses import ARMS_DOWN, LUNGE, REACH, stage_view
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (256, 144)
CAMERA = Camera(eye=(0.0, 1.6, 5.5), target=(0.0, 0.9, 0.0), field_of_view_deg=40.0)
OTHER = {"LowerLeg": 0.8, "Foot": 0.85, "UpperArm": 1.2, "LowerArm": 1.2, "Hand": 1.1, "head": 1.3}


def three_dancers():
    return stage_view([(LUNGE, (-1.5, 0.0), 20.0, 0), (ARMS_DOWN, (0.0, 0.3), 0.0, 1), (REACH, (1.5, 0.0), 0.0, 2)])


@pytest.fixture(scope="module")
def renderers(headless_context, tmp_path_factory):
    """Cached renderers by character file, quality and bodies, for all tests of this file."""
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
def draw_characters(gl_context, renderers):
    """The picture of three dancers with the character of a file (None: the generated body)."""

    def once(data, quality=SOFTWARE, view=None, bodies=("anna",) * 3, **styles):
        renderer, begin = renderers(data, quality, bodies)
        target = gl_context.simple_framebuffer(SIZE)
        assert gl_context.error
        view = view or three_dancers()
        view.picture = picture_row(begin)
        for name, value in styles.items():
            for group in range(3):
                view.picture[group_parameter(f"/dance/draw/{name}", group).row_slice] = value
        renderer.draw(view, target)
        assert gl_context.error == "GL_NO_ERROR"
        picture = read(target)
        target.release()
        return picture

    return once


def empty_view():
    view = three_dancers()
    view.present[:] = False
    return view


def dancer_mask(picture, empty):
    """Pixels that show a dancer: different from the empty stage by more than a floor shadow."""
    return np.abs(picture.astype(int) - empty).max(axis=2) > 24


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])
def test_body_read_from_file_has_outline_of_generated_body(draw_characters, quality):
    near = float(np.linalg.norm(np.subtract(CAMERA.eye, CAMERA.target))) < quality.close_within
    level = quality.close_level if near and quality.close_count >= 3 else quality.near_level
    white, red = {"silhouette": 1.0, "solid": 0.0}, "silhouette/colour"
    body = draw_characters(None, quality, **white, **{red: (1.0, 1.0, 1.0)})
    own = draw_characters(glb_of(level=level, names=mixamo), quality, **white, **{red: (1.0, 1.0, 1.0)})
    inside = body.min(axis=2) > 200
    assert inside.mean() > 0.015
    assert (inside != (own.min(axis=2) > 200)).sum() <= 0.01 * inside.sum()


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])
def test_character_of_other_proportions_covers_dancer(draw_characters, quality):
    empty = draw_characters(None, quality, view=empty_view())
    body = dancer_mask(draw_characters(None, quality), empty)
    own = dancer_mask(
        draw_characters(glb_of(names=mixamo, image=striped_image(), lengths=OTHER, arms_down=50.0), quality), empty
    )
    assert (body & own).sum() > 0.88 * max(body.sum(), own.sum())


@pytest.mark.long
def test_material_colour_applies_and_transparent_pixels_are_cut_out(draw_characters):
    red = draw_characters(glb_of(colour=(0.8, 0.0, 0.0, 1.0))).astype(int)
    assert ((red[..., 0] > red[..., 2] + 40) & (red[..., 0] > red[..., 1] + 40)).mean() > 0.02
    blue = draw_characters(glb_of(colour=(0.0, 0.0, 0.8, 1.0))).astype(int)
    assert (blue[..., 2] > blue[..., 0] + 60).mean() > 0.02
    out = io.BytesIO()
    Image.fromarray(np.full((4, 4, 4), (255, 255, 255, 0), np.uint8)).save(out, "PNG")
    root, chunk = document(Figure(image=out.getvalue()))
    root["materials"][0]["alphaMode"] = "MASK"
    empty, above = draw_characters(None, view=empty_view()), slice(0, SIZE[1] // 2)  # where no shadow falls
    clear = dancer_mask(draw_characters(glb(root, chunk)), empty)[above]
    assert clear.mean() < 0.001 < 0.02 < dancer_mask(draw_characters(glb_of()), empty)[above].mean()


@pytest.mark.long
def test_golden_character(draw_characters, golden):
    data = glb_of(image=striped_image(128), names=mixamo, lengths=OTHER, arms_down=50.0, level=2, double=True)

    def law(picture):  # striped shirts: red and white between the heads and the legs
        chest = picture[45:90].astype(int)
        red = (chest[..., 0] > chest[..., 1] + 60) & (chest[..., 0] > chest[..., 2] + 60)
        return bool(red.mean() > 0.008 and (chest.min(axis=2) > 150).mean() > 0.004)

    golden(draw_characters(data), "character", law=law)
    golden(draw_characters(data, HARDWARE), "character_card", law=law)


@mostly_long("style", ["ink", "particles", "xray", "trails", "ribbons"], quick=[1, 2, 3, 4])
def test_every_style_changes_character_picture(draw_characters, style):
    data = glb_of(image=striped_image())
    plain, styled = draw_characters(data), draw_characters(data, **{"solid": 0.0, style: 1.0})
    assert np.abs(plain.astype(int) - styled).mean() > 0.5


@pytest.mark.long
def test_character_is_drawn_next_to_generated_bodies(draw_characters):
    view = three_dancers()
    view.group[:] = 1  # in blue
    picture = draw_characters(
        glb_of(colour=(0.9, 0.0, 0.0, 1.0)), view=view, bodies=("dancer", "anna", "dancer")
    ).astype(int)
    red = (picture[..., 0] > 2 * picture[..., 1] + 30) & (picture[..., 0] > 2 * picture[..., 2] + 30)
    middle = slice(SIZE[0] // 2 - 30, SIZE[0] // 2 + 30)
    assert red[:, middle].sum() > 200
    assert red.sum() == red[:, middle].sum()


@pytest.mark.long
def test_character_is_drawn_with_the_far_body(draw_characters):
    """One dancer too many for the near bodies wears it: as large as near, and red."""
    near, far = (
        draw_characters(glb_of(colour=(0.9, 0.0, 0.0, 1.0)), replace(SOFTWARE, near_count=count, far_from=0.0)).astype(
            int
        )
        for count in (3, 0)
    )
    for picture in (near, far):
        assert ((picture[..., 0] > 2 * picture[..., 1] + 30) & (picture[..., 0] > 2 * picture[..., 2] + 30)).sum() > 600
    assert (np.abs(near - far).max(axis=2) > 30).mean() < 0.01


def solid_colour_png(*rgb):
    """A PNG of one colour."""
    out = io.BytesIO()
    Image.fromarray(np.full((8, 8, 3), rgb, np.uint8)).save(out, "PNG")
    return out.getvalue()


def with_material(image=None, **material):
    """A grey figure with further material fields; `image` is its only image."""
    root, chunk = document(Figure(colour=(0.4, 0.4, 0.4, 1.0), image=image))
    root["materials"][0] |= material
    root["materials"][0]["pbrMetallicRoughness"].pop("baseColorTexture", None)
    return glb(root, chunk)


@pytest.mark.long
def test_normal_map_affects_lighting_and_emission_shows_in_dark(gl_context, tmp_path):
    """In a row: plain, normals turned up, normals turned to +x, and a green emitter."""
    bumps = {"normalTexture": {"index": 0}}
    glow = {
        "emissiveFactor": [0.0, 0.5, 0.0],
        "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2.0}},
    }
    files = (
        with_material(),
        with_material(solid_colour_png(128, 220, 216), **bumps),
        with_material(solid_colour_png(220, 128, 216), **bumps),
        with_material(solid_colour_png(0, 255, 255), **glow),
    )
    for number, data in enumerate(files):
        (tmp_path / f"{number}.glb").write_bytes(data)
    names = ("plain", "up", "right", "glow")
    known = tuple(CharacterFile(name, str(tmp_path / f"{n}.glb")) for n, name in enumerate(names))
    of = replace(scene(4, CAMERA), characters=known, bodies=names)
    places = (-1.8, -0.6, 0.6, 1.8)
    view = stage_view([(ARMS_DOWN, (x, 0.0), 0.0, 0) for x in places])
    renderer, target = Renderer(gl_context, of, size=SIZE, quality=HARDWARE), gl_context.simple_framebuffer(SIZE)
    assert gl_context.error

    def chests(**light):
        """Brightness of the chest of each dancer, (4, 3)."""
        view.picture = picture_row(of)
        said = {"key": 0.0, "rim": 0.0, "ambient": 0.0, "stage": 0.0} | light
        for name, value in said.items():
            view.picture[BY_ADDRESS[f"/dance/light/{name.replace('__', '/')}"].row_slice] = value
        renderer.draw(view, target)
        assert gl_context.error == "GL_NO_ERROR"
        picture = read(target).astype(float)
        at = project_points(CAMERA, SIZE, view.joint_position[:, 3] + (0.0, 0.0, 0.1)).astype(int)
        return np.array([picture[y - 3 : y + 4, x - 2 : x + 3].mean(axis=(0, 1)) for x, y in at])

    dark = chests()
    assert dark[:3].max() < 8.0  # haze alone
    assert dark[3, 1] > 100.0 > 3.0 * dark[3, [0, 2]].max()
    above = chests(key=1.0, key__direction=(0.0, -1.0, -0.35)).mean(axis=1)
    assert above[1] > 1.15 * above[0]
    from_right = chests(side=1.5, side__left=(0, 0, 0), side__right=(1, 1, 1)).mean(axis=1)
    from_left = chests(side=1.5, side__right=(0, 0, 0), side__left=(1, 1, 1)).mean(axis=1)
    assert from_right[2] > 1.15 * from_right[0]
    assert from_left[2] < 0.85 * from_left[0]
    for thing in (renderer, target):
        thing.release()


def test_second_uv_set_and_unlit_materials_are_ignored():
    def read(**material):
        root, chunk = document(Figure(image=striped_image()))
        root["materials"][0] |= material
        return parse_model(glb(root, chunk), "a.glb").materials[0]

    plain = {
        "normalTexture": {"index": 0, "scale": 0.5},
        "emissiveFactor": [1, 0.5, 0],
        "emissiveTexture": {"index": 0},
    }
    whole = read(**plain)
    assert (whole.normal_image, whole.normal_strength, whole.emission, whole.emission_image) == (
        0,
        0.5,
        (1.0, 0.5, 0.0),
        0,
    )
    assert not read(**plain, extensions={"KHR_materials_unlit": {}}).has_extras
    other = {"normalTexture": {"index": 0, "texCoord": 1}, "emissiveTexture": {"index": 0, "texCoord": 1}}
    assert not read(**plain | other).has_extras
    assert read(emissiveFactor=[5.0, -1.0, 0.25]).emission == (1.0, 0.0, 0.25)


def test_invalid_or_excess_normal_maps_keep_colour_images(tmp_path):
    root, chunk = document(Figure(image=striped_image()))
    chunk = chunk + b"no image"
    root["buffers"][0]["byteLength"] = len(chunk)
    root["bufferViews"].append({"buffer": 0, "byteOffset": len(chunk) - 8, "byteLength": 8})
    root["images"].append({"bufferView": len(root["bufferViews"]) - 1, "mimeType": "image/png"})
    root["textures"].append({"source": 1})
    glow = {"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 1}}
    root["materials"][0] |= {"normalTexture": {"index": 1}, **glow}
    (tmp_path / "a.glb").write_bytes(glb(root, chunk))
    found = load_character(CharacterFile("a", str(tmp_path / "a.glb")))
    assert found.model.notes == (LEFT_OUT_NOTE,)
    assert len(found.layers) == 2
    assert not found.extras[:, 3].any()  # without its image it would glow all over
    many = [Material(str(n), (1, 1, 1, 1), n, 0.0, False, 0.5, False, normal_image=40 + n) for n in range(15)]
    images = tuple(solid_colour_png(n, n, n) for n in range(60))
    layers, known, notes = layers_of(SimpleNamespace(images=images, file="a.glb"), many)
    assert (len(layers), len(known), notes) == (16, 15, (LEFT_OUT_NOTE,))
    layers, known, notes = layers_of(SimpleNamespace(images=images, file="a.glb"), many[:10])
    assert (len(layers), len(known), notes) == (21, 20, ())
    assert layers[known[43, True], 0, 0, 0] == 43  # normals are no colours
    assert layers[known[3, False], 0, 0, 0] == round(255 * (3 / 255 / 12.92) ** 0.5)
