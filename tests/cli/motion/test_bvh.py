"""`live bvh`: every key of the JSON report, the joints file, and one-line errors."""

import json
from pathlib import Path

import numpy as np
import pytest

from live.motion.skeleton import SKELETON
from tests.cli.command import run_live
from tests.fixtures.mocap import mocap_file
from tests.motion.formats.made_bvh import NAMES, body_bvh, still

KEYS = (
    "joints end_sites channels frames frames_declared header_fps fps seconds unit_m up root_offset tpose_first floor_m "
    "height_m travel_m mapped warnings"
)


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    values = still(31)
    values[:, 2] = np.linspace(0.0, 120.0, 31)
    path = tmp_path / "walk.bvh"
    path.write_text(body_bvh(values, fps=30.0, declared=32))
    return path


def test_json_contains_all_keys(walk: Path, tmp_path: Path) -> None:
    out = tmp_path / "joints.npz"
    done = run_live("bvh", str(walk), "--json", "--joints", str(out))
    assert (done.returncode, done.stderr) == (0, "")
    facts = json.loads(done.stdout)
    assert list(facts) == KEYS.split()
    assert (facts["joints"], facts["end_sites"], facts["channels"], facts["frames"]) == (21, 5, 66, 31)
    assert (facts["frames_declared"], facts["up"], facts["root_offset"], facts["tpose_first"]) == (
        32,
        "Y",
        "zero",
        False,
    )
    assert facts["unit_m"] == 0.01
    assert facts["travel_m"] == pytest.approx(1.2)
    assert list(facts["mapped"]) == list(SKELETON.names)
    assert facts["mapped"]["leftUpperArm"] == "LeftArm"
    assert facts["warnings"] == [{"what": "says 32 frames, holds 31 data lines: all of them are used"}]
    with np.load(out) as written:
        assert sorted(written.files) == ["names", "positions"]
        assert written["names"].tolist() == list(NAMES)
        assert written["positions"].dtype == np.float64
        assert written["positions"].shape == (31, 21, 3)
        np.testing.assert_allclose(written["positions"][:, 0, 2], np.linspace(0.0, 1.2, 31), atol=1e-9)


def test_options_override_file_values(walk: Path) -> None:
    done = run_live("bvh", str(walk), "--json", "--fps", "60", "--unit", "0.0254", "--up", "y")
    facts = json.loads(done.stdout)
    assert (facts["fps"], facts["unit_m"], facts["up"]) == (60.0, 0.0254, "Y")
    assert facts["seconds"] == pytest.approx(31 / 60)
    assert facts["header_fps"] == pytest.approx(30.0)
    assert any("4.4 m tall" in one["what"] for one in facts["warnings"])


def test_table_contains_facts_and_warnings(walk: Path) -> None:
    done = run_live("bvh", str(walk))
    assert done.returncode == 0
    for words in (
        "21 joints, 5 end sites, 66 channels",
        "31 (the file says 32), 30 a second: 1.03 s",
        "1.2 m",
        "LeftArm",
    ):
        assert words in done.stdout
    assert "warning" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.bvh"], "none.bvh: there is no such file; there are: broken.bvh, walk.bvh"),
        (["broken.bvh"], "broken.bvh, line 3: 'x' as OFFSET y is not a number; a decimal number expected"),
        (["walk.bvh", "--fps", "0"], "--fps 0: 1 to 10000 expected"),
        (["walk.bvh", "--unit", "-1"], "--unit -1"),
        (["walk.bvh", "--up", "X"], "--up 'X': Y or Z expected"),
        (["walk.bvh", "--joints", "."], "that is a folder"),
    ],
)
def test_failure_has_exit_code_2_and_one_line(walk: Path, arguments: list[str], words: str) -> None:
    (walk.parent / "broken.bvh").write_text("HIERARCHY\nROOT a {\nOFFSET 0 x 0\n")
    done = run_live("bvh", *arguments, "--json", cwd=walk.parent)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_input_recording_is_never_overwritten(walk: Path) -> None:
    before = walk.read_bytes()
    done = run_live("bvh", "walk.bvh", "--joints", "walk.bvh", cwd=walk.parent)
    assert done.returncode == 2
    assert "--joints walk.bvh: a name that ends in .npz expected" in done.stderr
    assert walk.read_bytes() == before
    archive = walk.with_name("walk.npz")
    archive.write_bytes(before)
    done = run_live("bvh", "walk.npz", "--joints", "walk.npz", cwd=walk.parent)
    assert done.returncode == 2
    assert "--joints walk.npz: that is the input file" in done.stderr
    assert archive.read_bytes() == before


@pytest.mark.shared
@pytest.mark.parametrize("name", ["group/perfume_aachan.glb"])
def test_other_motion_formats_are_reported(name: str) -> None:
    done = run_live("bvh", str(mocap_file(name)), "--json")
    facts = json.loads(done.stdout)
    assert (list(facts), facts["up"]) == (KEYS.split(), "Y")
    assert 1.5 < facts["height_m"] < 1.9
