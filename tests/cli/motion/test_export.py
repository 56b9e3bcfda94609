"""`live export`: recordings and steps become files that read back as the same motion; refusals name a remedy."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.cli.motion.export import export
from live.library.motion_file import read_motion
from live.library.step_folder import load_folder
from live.motion.clip import Clip
from live.motion.formats.source_motion import LocalPose, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.fixtures.mocap import mocap_file
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, dance_values


def joint_positions(clip: Clip) -> np.ndarray:
    return forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))[0]


def read_joints(path: Path) -> np.ndarray:
    """Joints of a written file [m], (T, 22, 3)."""
    motion = read_motion(path)
    assert motion.names == SKELETON.names
    found = world_pose(motion.parents, LocalPose(motion.translation, motion.rotation)).positions
    return found * (0.01 if path.suffix.lower() == ".bvh" else 1.0)


@pytest.fixture
def dance(tmp_path: Path) -> Path:
    path = tmp_path / "dance.bvh"
    path.write_text(body_bvh(dance_values(61), fps=30.0))
    return path


@mostly_long("name", ["out.bvh", "out.glb", "out.vrma", "OUT.BVH"], quick=[0, 1])
def test_exported_recording_equals_engine_clip(dance: Path, name: str) -> None:
    out = dance.with_name(name)
    result = run_live("export", str(dance), "--to", str(out))
    assert result.returncode == 0, result.stderr
    assert "121 frames, 60 per second, 2.00 s" in result.stdout
    clip = retarget(read_motion(dance), name="dance")
    np.testing.assert_allclose(read_joints(out), joint_positions(clip), atol=1e-5)
    np.testing.assert_allclose(
        joint_positions(retarget(read_motion(out), name="again")), joint_positions(clip), atol=1e-5
    )


@pytest.mark.parametrize(("rate", "frames"), [("source", 61), ("30", 61), ("24", 49), (" 120 ", 241)])
def test_frame_rate_option_sets_frame_count(dance: Path, rate: str, frames: int) -> None:
    out = dance.with_name("out.bvh")
    export(str(dance), out, rate=rate)
    assert read_motion(out).frame_count == frames


def test_file_options_override_file_values(dance: Path) -> None:
    out = dance.with_name("out.bvh")
    export(str(dance), out, fps=60.0, drop_frames=11)
    motion = read_motion(out)
    assert (motion.frame_count, round(motion.header_fps)) == (50, 60)
    clip = retarget(read_motion(dance), name="dance", fps=60.0, drop_frames=11)
    np.testing.assert_allclose(read_joints(out), joint_positions(clip), atol=1e-5)


@pytest.mark.shared
@mostly_long(
    ("name", "options"),
    [
        ("group/perfume_aachan.glb", {}),
        ("solo/rokoko_jesse_dance.bvh", {"up": "y"}),
    ],
    quick=[1],
)
def test_real_files_of_other_formats_are_exported(tmp_path: Path, name: str, options: dict[str, Any]) -> None:
    path = mocap_file(name)
    out = tmp_path / "out.glb"
    export(str(path), out, **options)
    clip = retarget(read_motion(path), name="dance")
    np.testing.assert_allclose(read_joints(out), joint_positions(clip), atol=1e-5)


def test_step_is_exported_whole_from_first_beat(tmp_path: Path) -> None:
    out = tmp_path / "walk.bvh"
    result = run_live("export", "Walk", "--to", str(out), "--variation", "2", "--rate", "source")
    assert result.returncode == 0, result.stderr
    step = [clip for clip in load_folder(PATCHES / "steps") if clip.step == "walk"][1]
    assert step.first == int(step.first)
    samples = int(step.measures * step.samples_per_measure + 1e-3) + 1
    expected = joint_positions(step.clip)[int(step.first) : int(step.first) + samples]
    np.testing.assert_allclose(read_joints(out), expected, atol=1e-5)


def test_library_step_is_exported_with_chosen_measures(dance: Path) -> None:
    words = 'file = "dance.bvh"\nname = "sway"\nbpm = 240\nfirst_beat_s = 0.1\nmeasures = 1\nbeats_per_measure = 3\n'
    (dance.parent / "steps.toml").write_text(words.replace("measures = 1", "measures = 2"))
    out = dance.with_name("out.glb")
    export("sway", out, library=dance.parent)
    assert read_motion(out).frame_count == 91
    export("sway", out, library=dance.parent, measures=1, force=True)
    assert read_motion(out).frame_count == 46


REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("{dance}", {"to": "out.fbx"}, r"ends in \.bvh, \.glb, \.vrma"),
    ("{dance}", {"to": "out"}, r"ends in \.bvh"),
    ("{dance}", {"to": "there.glb"}, "exists already.*--force"),
    ("{dance}", {"to": "dance.bvh", "force": True}, "is the input file"),
    ("{dance}", {"to": "nowhere/out.bvh"}, "there is no folder"),
    ("{dance}", {"rate": "fast"}, "1 to 1000 frames per second expected, or source"),
    ("{dance}", {"rate": "nan"}, "1 to 1000"),
    ("{dance}", {"fps": 0.0}, "--fps 0"),
    ("{dance}", {"up": "X"}, "--up 'X': Y or Z expected"),
    ("{dance}", {"unit": 1.0}, "unit_m 1"),
    ("{dance}", {"drop_frames": 61}, "drop_frames 61: 0 to 60"),
    ("{dance}", {"drop_frames": -1}, "drop_frames -1"),
    ("{dance}", {"measures": 1}, "--measures: .* is a file"),
    ("walk", {"fps": 60.0, "up": "Y"}, "--fps: 'walk' is a step.*leave --fps and --up out"),
    ("walk", {"variation": 0}, "--variation 0: the step 'walk' has 18: 1 in place, 2 short forward"),
    ("walk", {"variation": 19}, "--variation 19"),
    ("walk", {"measures": 0}, "--measures 0: the step 'walk' has"),
    ("wolk", {}, "there is no file and no step 'wolk'.*live export 'walk'"),
    ("x\0y", {}, "there is no file and no step"),
    ("missing.bvh", {}, r"missing\.bvh: there is no such file"),
    ("missing/walk", {}, "there is no such file"),
    ("{broken}", {}, "line 1: .* a BVH file begins with HIERARCHY"),
    ("walk", {"library": "{empty}"}, "empty"),
]


@pytest.mark.parametrize(("source", "options", "message"), REFUSED)
def test_refusals_name_option_and_remedy(dance: Path, source: str, options: dict[str, Any], message: str) -> None:
    folder = dance.parent
    (folder / "there.glb").write_bytes(b"mine")
    (folder / "broken.bvh").write_text("ROOT Hips")
    (folder / "empty").mkdir()
    names = {"dance": str(dance), "broken": str(folder / "broken.bvh")}
    options = dict(options)
    out = folder / options.pop("to", "out.bvh")
    if "library" in options:
        options["library"] = folder / "empty"
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    with pytest.raises(PersonError, match=f"(?s){message}"):
        export(source.format(**names), out, **options)
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_refusal_has_exit_code_two_and_error_with_remedy(dance: Path) -> None:
    result = run_live("export", str(dance), "--to", str(dance.with_name("out.txt")))
    assert result.returncode == 2
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 2  # the error, and what to try
    assert "Traceback" not in result.stderr
