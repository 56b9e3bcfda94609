"""Choice of the reader for a motion file, and error messages for unsupported files."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from live.library.motion_file import MAX_BYTES, read_motion
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from tests.fixtures.mocap import mocap_file
from tests.motion.formats.made_bvh import body_bvh, dance_values


@pytest.mark.parametrize("name", ["a.bvh", "a.BVH", "a.txt", "a.c3d", "no ending"])
def test_bvh_is_recognized_by_content(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(body_bvh(dance_values(5)))
    motion = read_motion(tmp_path / name)
    expected = bvh_to_source_motion(parse_bvh(body_bvh(dance_values(5)), "x"))
    np.testing.assert_array_equal(motion.rotation, expected.rotation)
    assert motion.file == str(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.c3d", b"\x02\x50" + bytes(600), "C3D files hold markers and no skeleton; solve the markers"),
        ("a.bvh", b"\x02\x50" + bytes(600), "C3D files hold markers"),
        ("a.fbx", b"Kaydara FBX Binary  \x00", "FBX files are not read; open it in Blender"),
        ("a.bvh", b"Kaydara FBX Binary  \x00", "FBX files are not read"),
        ("a.fbx", b"; FBX 7.3.0 project file", "FBX files are not read"),
        ("a.glb", b"glTF", "a.glb"),
        ("a.gltf", b"{", "a.gltf"),
        ("a.npz", b"PK\x03\x04", "a.npz"),
        ("a.bvh", b" ", "a BVH file begins with HIERARCHY"),
        ("a.bvh", b"", "a.bvh: the file is empty; copy it or export it again"),
        ("a.glb", b"", "the file is empty"),
        ("a.xyz", b"words", "no reader for .xyz files is installed; there are BVH (.bvh), glTF (.glb"),
    ],
)
def test_unsupported_file_is_refused_with_remedy(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MotionFileError) as caught:
        read_motion(tmp_path / name)
    assert words in str(caught.value)
    assert str(tmp_path / name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_special_or_oversized_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "dance.bvh").write_text("x")
    with pytest.raises(MotionFileError, match=r"danse.bvh: there is no such file; there are: dance.bvh"):
        read_motion(tmp_path / "danse.bvh")
    with pytest.raises(MotionFileError, match=r"that is a folder; name a file in it: dance.bvh$"):
        read_motion(tmp_path)
    os.mkfifo(tmp_path / "pipe.bvh")
    with pytest.raises(MotionFileError, match="that is a device or a pipe, not a file"):
        read_motion(tmp_path / "pipe.bvh")
    with pytest.raises(MotionFileError):
        read_motion(Path("a\0b"))
    with (tmp_path / "huge.bvh").open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(MotionFileError, match="more than 256000000 bytes; cut it into pieces"):
        read_motion(tmp_path / "huge.bvh")


@pytest.mark.shared
def test_glb_is_recognized_by_content(tmp_path: Path) -> None:
    shutil.copy(mocap_file("group/perfume_aachan.glb"), tmp_path / "any.name")
    assert read_motion(tmp_path / "any.name").joint_count == 23


def test_given_up_axis_is_used_for_bvh(tmp_path: Path) -> None:
    values = dance_values(60)
    (tmp_path / "z.bvh").write_text(body_bvh(values, z_up=True, offsets={"Hips": (3.0, 94.0, 7.0)}))
    assert read_motion(tmp_path / "z.bvh").root_offset == "replace"
    assert read_motion(tmp_path / "z.bvh", up="Z").up == "Z"
