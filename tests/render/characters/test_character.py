"""Invalid character files: each is refused with its file name, memory limit and folder boundary."""

import io
import json
import struct
import time
import zlib

import numpy as np
import pytest
from PIL import Image

from live.base.body.catalogue import CharacterFile
from live.base.errors import PersonError
from live.render.characters.character import load_character
from live.render.characters.model_reader import BYTE_LIMIT, parse_model
from tests.render.characters.figures import Figure, document, glb, glb_of, striped_image


def damaged_glb(change, **wanted):
    root, chunk = document(Figure(**wanted))
    chunk = bytearray(chunk)
    change(root, chunk)
    return glb(root, bytes(chunk))


def pack_value(view, place, value, form):
    def change(root, chunk):
        struct.pack_into(form, chunk, root["bufferViews"][view]["byteOffset"] + place, value)

    return change


def set_value(*keys, value):
    def change(root, _):
        for key in keys[:-1]:
            root = root[key]
        root[keys[-1]] = value

    return change


def remove_skin(root, _):
    del root["skins"]
    del root["nodes"][-1]["skin"]


def collapse_bones(root, _):
    for node in root["nodes"]:
        node["translation"] = [0.0, 0.0, 0.0]


POSITION, JOINTS, INDICES = 0, 3, 5
CASES = {
    "no skin": (remove_skin, "has no skin"),
    "no place": (pack_value(POSITION, 0, float("nan"), "<f"), "not usable"),
    "a vertex that is not there": (pack_value(INDICES, 0, 10**6, "<I"), "refer to vertex 1000000"),
    "a joint that is not there": (pack_value(JOINTS, 0, 200, "<B"), "refers to joint 200 of 22"),
    "a material that is not there": (set_value("meshes", 0, "primitives", 0, "material", value=3), "material is 3"),
    "an accessor that is not there": (set_value("meshes", 0, "primitives", 0, "indices", value=99), "no number 99"),
    "an accessor that is too long": (set_value("accessors", 0, "count", value=10**9), "numbers|beyond|exceed"),
    "a view beyond the end": (set_value("bufferViews", 0, "byteLength", value=10**8), "ends at byte"),
    "lines": (set_value("meshes", 0, "primitives", 0, "mode", value=1), "hold no triangles"),
    "a scale of nothing": (set_value("nodes", 0, "scale", value=[0.0, 0.0, 0.0]), "scale is"),
    "a mirrored bone": (set_value("nodes", 3, "scale", value=[-1.0, 1.0, 1.0]), "scale is"),
    "a circle of nodes": (lambda root, _: root["nodes"][5].setdefault("children", []).append(0), "cycle|has a parent"),
    "compressed": (set_value("extensionsRequired", value=["KHR_draco_mesh_compression"]), "needs KHR_draco"),
    "bones in one place": (collapse_bones, "in one place"),
    "nothing that moves it": (
        lambda root, _: root["meshes"][0]["primitives"][0]["attributes"].pop("JOINTS_0"),
        "cannot be animated",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_damaged_file_is_refused_with_reason(case, tmp_path):
    change, words = CASES[case]
    path = tmp_path / "anna.glb"
    path.write_bytes(damaged_glb(change))
    with pytest.raises(PersonError, match=words) as refused:
        load_character(CharacterFile("anna", str(path)))
    assert "anna.glb" in refused.value.message
    assert "\n" not in str(refused.value)
    assert refused.value.remedy


@pytest.mark.parametrize(
    ("begin", "words", "remedy"),
    [
        (b"Kaydara FBX Binary  \0", "an FBX file", "File > Import > FBX"),
        (b"BLENDER-v402", "a Blender file", "Export > glTF"),
        (b"PK\x03\x04", "a ZIP archive", "unpack"),
        (b"version https://git-lfs.github.com/spec/v1\n", "pointer of Git LFS", "git lfs pull"),
        (b"<!doctype html><html>", "a web page", "download it again"),
        (b"solid of something", "was read", "glTF"),
    ],
)
def test_file_of_another_format_is_refused_with_what_to_do(begin, words, remedy, tmp_path):
    path = tmp_path / "anna.glb"
    path.write_bytes(begin + bytes(200))
    with pytest.raises(PersonError, match=words) as refused:
        load_character(CharacterFile("anna", str(path)))
    assert remedy in (refused.value.remedy or "")
    assert "anna.glb" in refused.value.message


def test_three_million_triangles_are_refused_before_they_are_read(tmp_path):
    """With the bytes of as many, and with a header that only claims them."""

    def claim(root, chunk):
        root["accessors"][INDICES]["count"] = 9_000_000
        view = root["bufferViews"][root["accessors"][INDICES]["bufferView"]]
        view |= {"byteOffset": len(chunk), "byteLength": 36_000_000}
        chunk.extend(bytes(36_000_000))
        root["buffers"][0]["byteLength"] = len(chunk)

    path = tmp_path / "anna.glb"
    path.write_bytes(damaged_glb(claim))
    begin = time.process_time()
    with pytest.raises(PersonError, match="3,000,000 triangles; 300,000 at most are read") as refused:
        load_character(CharacterFile("anna", str(path)))
    assert time.process_time() - begin < 1.0
    assert "Decimate" in (refused.value.remedy or "")


def test_oversized_file_is_refused(tmp_path):
    path = tmp_path / "anna.glb"
    with path.open("wb") as file:
        file.truncate(2 * BYTE_LIMIT)
    with pytest.raises(PersonError, match="200 MB; 100 MB at most are read") as refused:
        load_character(CharacterFile("anna", str(path)))
    assert "fewer triangles" in (refused.value.remedy or "")


def png_with_claimed_size(width, height):
    """A PNG of a few bytes whose header claims a large size."""

    def part(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", zlib.compress(b"\0")) + part(b"IEND", b"")


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (png_with_claimed_size(60000, 60000), "image 0"),
        (png_with_claimed_size(9000, 10), "9000 x 10"),
        (b"GIF89a" + bytes(40), "no PNG, JPEG or WebP"),
        (striped_image()[:90], "image 0 is"),
        (png_with_claimed_size(64, 64), "broken"),
    ],
)
def test_invalid_image_is_refused_with_reason(image, words, tmp_path):
    path = tmp_path / "anna.glb"
    path.write_bytes(glb_of(image=image))
    with pytest.raises(PersonError, match=words):
        load_character(CharacterFile("anna", str(path)))


def write_gltf(tmp_path, uri):
    """A .gltf with its binary chunk next to it, and an image at `uri`."""
    root, chunk = document(Figure())
    root["buffers"][0]["uri"] = "anna.bin"
    root["images"], root["textures"] = [{"uri": uri}], [{"source": 0}]
    root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    (tmp_path / "anna.bin").write_bytes(chunk)
    path = tmp_path / "anna.gltf"
    path.write_text(json.dumps(root))
    return CharacterFile("anna", str(path))


def test_external_images_are_read_only_below_model_folder(tmp_path):
    folder = tmp_path / "model"
    (folder / "images").mkdir(parents=True)
    (folder / "images" / "red cloth.png").write_bytes(striped_image())
    (tmp_path / "secret.png").write_bytes(striped_image())
    (folder / "link.png").symlink_to(tmp_path / "secret.png")
    assert len(load_character(write_gltf(folder, "images/red%20cloth.png")).layers) == 2
    for uri, words in (
        ("images/blue.png", "missing"), ("../secret.png", "same folder"), ("/etc/passwd", "same folder"),
        ("link.png", "out of its folder"), ("data:image/png;base64,!", "base64"),
        ("images/%2e%2e/%2e%2e/a.png", "folder"),
    ):  # fmt: skip
        with pytest.raises(PersonError, match=words):
            load_character(write_gltf(folder, uri))


def test_colours_are_stored_as_square_roots_of_linear_light(tmp_path):
    out = io.BytesIO()
    Image.fromarray(np.full((4, 4, 4), (188, 0, 255, 128), np.uint8)).save(out, "PNG")
    path = tmp_path / "anna.glb"
    path.write_bytes(glb_of(image=out.getvalue()))
    layers = load_character(CharacterFile("anna", str(path))).layers
    linear = (layers[1, 0, 0, :3] / 255.0) ** 2
    assert linear == pytest.approx([0.5029, 0.0, 1.0], abs=0.004)  # sRGB 188 is half the light (IEC 61966-2-1)
    assert layers[1, 0, 0, 3] == 128
    assert (layers[0] == 255).all()


def test_first_person_mesh_is_omitted_and_license_is_read():
    def own_eyes(root, _):
        root["nodes"].append({"name": "eyes", "mesh": 0, "skin": 0})
        root["meshes"].append(root["meshes"][0])
        root["nodes"][-1]["mesh"] = 1
        root["extensions"]["VRM"]["firstPerson"] = {
            "meshAnnotations": [{"mesh": 1, "firstPersonFlag": "FirstPersonOnly"}]
        }

    model = parse_model(damaged_glb(own_eyes, vrm="0.x"), "anna.vrm")
    assert len(model.parts) == 1
    assert "first-person view" in model.notes[0]
    assert model.kind == "VRM 0.x"
    assert model.licence["author"] == "somebody"
    assert model.licence["licence"] == "CC0"
    assert parse_model(glb_of(vrm="1.0"), "anna.vrm").licence["author"] == "somebody"
