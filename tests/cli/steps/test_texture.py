"""`live texture` and `live steps enrich`: files, a report, versions beside sketches, refusals."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from live.library.motion_file import read_motion
from live.library.step_folder import load_folder
from live.library.textured_steps import textured_path
from live.motion.clip import resample
from live.motion.formats.bvh_writer import write_bvh
from live.motion.retarget.retarget import retarget
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.motion.texture.made_dance import dance


@pytest.fixture(scope="module")
def mocap(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two recordings, a too short one and an invalid one."""
    folder = tmp_path_factory.mktemp("mocap")
    for seed in (1, 2):
        (folder / f"dance{seed}.bvh").write_text(write_bvh(dance(10.0, seed).clip))
    (folder / "blink.bvh").write_text(write_bvh(resample(dance(4.0, 3).clip, 60.0, last=30.0)))
    (folder / "broken.bvh").write_text("HIERARCHY\nROOT x\n")
    return folder


@pytest.mark.long
def test_step_is_textured_and_report_names_source_recordings(mocap: Path, tmp_path: Path) -> None:
    out, report = tmp_path / "groove.bvh", tmp_path / "groove.json"
    asked = ("texture", "groove", "--with", str(mocap), "--out", str(out), "--paths", "2", "--report", str(report))
    result = run_live(*asked)
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("passed over:") == 2
    assert "blink" in result.stdout
    assert "0.50 s are too short" in result.stdout
    values = json.loads(report.read_text())
    assert values["out"] == [str(tmp_path / "groove-1.bvh"), str(tmp_path / "groove-2.bvh")]
    assert {one["recording"] for one in values["paths"][0]["fragments"]} <= {"dance1", "dance2"}
    sketch = load_folder(PATCHES / "steps")
    step = next(step for step in sketch if step.step == "groove")
    for file in values["out"]:
        clip = retarget(read_motion(Path(file)), name="made")
        assert abs(clip.seconds - step.measures * 240.0 / step.bpm) < 0.04
    again = run_live(*asked)
    assert again.returncode == 2
    assert "the file exists already" in again.stderr


@pytest.mark.long
def test_sketch_gets_textured_versions_as_variations(mocap: Path, tmp_path: Path) -> None:
    library = tmp_path / "steps"
    library.mkdir()
    for name in ("groove", "bow"):
        shutil.copy(PATCHES / "steps" / f"{name}.toml", library)
    own = load_folder(library)
    result = run_live("steps", "enrich", "--with", str(mocap), "--library", str(library), "--step", "groove")
    assert result.returncode == 0, result.stderr
    assert "groove: 2 versions, upper body made" in result.stdout
    assert textured_path(library / "groove.toml").is_file()
    assert not textured_path(library / "bow.toml").is_file()
    rich = load_folder(library)
    assert len(rich) == len(own) + 4
    for clip in rich[len(own) :]:
        assert clip.step == "groove"
        assert clip.style in ("textured 1", "textured 2")
        assert (clip.clip.sample_rate, clip.measures) == (own[0].clip.sample_rate, 1)
    assert sum(clip.mirrored for clip in rich[len(own) :]) == 2
    assert np.array_equal(rich[0].clip.rotation, own[0].clip.rotation)

    with (library / "groove.toml").open("a") as file:
        file.write("# another one\n")
    assert len(load_folder(library)) == len(own)  # what was made of another text is not danced
    checked = run_live("steps", "check", "--library", str(library))
    assert "the sketch was changed since" in checked.stdout
    assert run_live("steps", "enrich", "--remove", "--library", str(library)).returncode == 0
    assert not textured_path(library / "groove.toml").is_file()


def test_damaged_file_of_versions_is_named_in_error(mocap: Path, tmp_path: Path) -> None:
    shutil.copy(PATCHES / "steps" / "walk.toml", tmp_path)
    for damage in (b"", b"[]\n", b'{"sketch": 3}\nAAAA\n', b"\xff\xfe", b'{"sketch": "x"}\n!!!\n'):
        textured_path(tmp_path / "walk.toml").write_bytes(damage)
        result = run_live("steps", "list", "--library", str(tmp_path))
        assert result.returncode == 2, damage
        assert "walk.textured: it holds no textured steps" in result.stderr
        assert "live steps enrich" in result.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("walk", "--with", "nowhere"), "there is no file and no folder nowhere"),
        (("wobble", "--with", "MOCAP"), "there is no step 'wobble'"),
        (("nothing.bvh", "--with", "MOCAP"), "there is no such file"),
        (("nothing.toml", "--with", "MOCAP"), "cannot read nothing.toml"),
        (("walk", "--with", "MOCAP", "--bands", "0-3"), "--bands '0-3'"),
        (("walk", "--with", "MOCAP", "--match", "40"), "band 40"),
        (("walk", "--with", "MOCAP", "--drive", "tail"), "no joint is called 'tail'"),
        (("walk", "--with", "MOCAP", "--synthesize", "legs", "--texture", "none"), "feet would slide"),
        (("walk", "--with", "MOCAP", "--variation", "99"), "--variation 99"),
        (("walk", "--with", "MOCAP/broken.bvh"), "broken.bvh"),
        (("walk", "--with", "MOCAP/blink.bvh"), "0.50 s are too short"),
        (("MOCAP/broken.bvh", "--with", "MOCAP"), "broken.bvh"),
        (("walk", "--with", "MOCAP", "--cut", "head.x"), "--cut 'head.x'"),
    ],
)
def test_invalid_options_are_refused(mocap: Path, tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    asked = [option.replace("MOCAP", str(mocap)) for option in options]
    result = run_live("texture", *asked, "--out", str(tmp_path / "out.bvh"), cwd=tmp_path)
    assert result.returncode == 2
    assert words in result.stderr
    assert not (tmp_path / "out.bvh").exists()


def test_nan_values_and_folders_without_motion_are_refused(tmp_path: Path) -> None:
    text = write_bvh(dance(2.0, 1).clip).splitlines()
    (tmp_path / "nan.bvh").write_text("\n".join([*text[:-5], "nan " + text[-5].partition(" ")[2], *text[-4:]]) + "\n")
    out = str(tmp_path / "out.bvh")
    result = run_live("texture", "walk", "--with", str(tmp_path / "nan.bvh"), "--out", out)
    assert result.returncode == 2
    assert "nan.bvh, line" in result.stderr
    alone = run_live("texture", "walk", "--with", str(tmp_path), "--out", out)
    assert alone.returncode == 2
    assert "none of 1 files can be used" in alone.stderr
    (tmp_path / "nan.bvh").unlink()
    empty = run_live("texture", "walk", "--with", str(tmp_path), "--out", out)
    assert "no motion files in" in empty.stderr
