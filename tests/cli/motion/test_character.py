"""`live character`: facts of a model as text and JSON, and refusal of invalid models."""

import json

import numpy as np
import pytest
from PIL import Image

from tests.cli.command import run_live
from tests.render.characters.figures import glb_of, striped_image


def test_bones_size_and_license_are_reported(tmp_path):
    path = tmp_path / "anna.vrm"
    path.write_bytes(glb_of(vrm="0.x", image=striped_image(), without=("neck",), unit=100.0))
    said = run_live("character", str(path))
    assert said.returncode == 0, said.stderr
    for words in ("VRM 0.x", "taken for centimetres", "21 of 22 joints", "without neck", "licence: CC0", "images: 1"):
        assert words in said.stdout
    facts = json.loads(run_live("character", str(path), "--json").stdout)
    assert facts["joints"]["neck"] is None
    assert facts["joints"]["leftHand"] == "leftHand"
    assert facts["materials"] == ["cloth"]
    assert facts["triangles_in_file"] == facts["triangles"][0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nobody.glb"], "there is no such file"),
        (["{anna}", "--joint", "hip=a"], "JOINT=BONE expected"),
        (["{anna}", "--joint", "hips=a"], "no bone is called 'a'"),
        (["{anna}", "--out", "a.bmp"], "ends in .png"),
    ],
)
def test_invalid_arguments_are_refused_in_one_line(arguments, words, tmp_path):
    path = tmp_path / "anna.glb"
    path.write_bytes(glb_of())
    said = run_live("character", *(each.format(anna=path) for each in arguments), cwd=tmp_path)
    assert said.returncode == 2
    assert words in said.stderr
    assert "Traceback" not in said.stderr


@pytest.mark.long
@pytest.mark.gl
def test_character_is_drawn_in_dance_poses(tmp_path):
    path, out = tmp_path / "anna.glb", tmp_path / "anna.png"
    path.write_bytes(glb_of(colour=(0.9, 0.0, 0.0, 1.0)))
    said = run_live("character", str(path), "--out", str(out), "--size", "192x108")
    assert said.returncode == 0, said.stderr
    picture = np.asarray(Image.open(out).convert("RGB")).astype(int)
    assert picture.shape == (108, 192, 3)
    red = (picture[..., 0] > 2 * picture[..., 1] + 30) & (picture[..., 0] > 2 * picture[..., 2] + 30)
    assert 0.01 < red.mean() < 0.3
    thirds = [red[:, 64 * n : 64 * (n + 1)].sum() for n in range(3)]
    assert min(thirds) > 30  # three of it
