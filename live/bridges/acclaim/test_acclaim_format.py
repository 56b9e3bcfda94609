"""Tests of Acclaim files as a motion format: the skeleton beside a motion, commands, and hostile files."""

import json
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from live.bridges.acclaim.acclaim_motion import parse_amc
from live.bridges.acclaim.acclaim_skeleton import parse_asf
from live.bridges.acclaim.motion_format import FORMAT
from live.bridges.acclaim.test_acclaim import AMC, ASF
from live.library import motion_formats
from live.library.add_step import add_step, request_entry
from live.library.motion_file import read_motion
from live.library.motion_formats import installed_formats
from live.library.recording_file import RecordingError
from live.library.step_folder import load_folder
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.file_report import analyze_motion
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.retarget import retarget
from tests.cli.command import run_live
from tests.cli.motion.test_bvh import KEYS
from tests.cli.motion.test_export import joint_positions, read_joints
from tests.fixtures.mocap import mocap_file
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.test_bvh_fuzz import attempt, mutate_text
from tests.motion.formats.test_reader_limits import read_limited

SKELETON = parse_asf(ASF.encode(), "test.asf")


def test_amc_uses_matching_asf_skeleton(tmp_path: Path) -> None:
    path = tmp_path / "7_01.amc"
    path.write_text(AMC)
    with pytest.raises(MotionFileError, match=r"its skeleton is not known; next to it: no .asf file; .*--skeleton"):
        read_motion(path)
    (tmp_path / "any.ASF").write_text(ASF)
    assert read_motion(path).joint_count == 4
    (tmp_path / "8.asf").write_text("broken")
    with pytest.raises(MotionFileError, match=r"next to it: 8.asf, any.ASF"):
        read_motion(path)
    (tmp_path / "7.asf").write_text(ASF)
    assert read_motion(path).joint_count == 4
    with pytest.raises(MotionFileError, match=r"8.asf, line 1: 'broken' was read"):
        read_motion(path, skeleton=tmp_path / "8.asf")
    with pytest.raises(MotionFileError, match=r"none.asf: there is no such file"):
        read_motion(path, skeleton=tmp_path / "none.asf")
    with pytest.raises(MotionFileError, match=r"7.asf: a skeleton without motion; its .amc file expected"):
        read_motion(tmp_path / "7.asf")


@pytest.mark.shared
@mostly_long("name", ["49_10", "49_11", "49_12", "49_14"], quick=[3])
def test_amc_files_load_skeleton_beside_them(name: str) -> None:
    facts, _ = analyze_motion(read_motion(mocap_file(f"asfamc/{name}.amc")))
    assert (facts.joints, facts.end_sites, facts.channels, facts.fps) == (31, 7, 62, 120.0)
    assert (facts.up, facts.root_offset, facts.tpose_first) == ("Y", "zero", False)
    assert facts.unit_m == pytest.approx(0.0564444, rel=1e-4)
    assert facts.floor_m == pytest.approx(0.012, abs=0.003)


@pytest.mark.long
@pytest.mark.shared
def test_asf_skeleton_is_copied_with_amc_recording(tmp_path: Path) -> None:
    source = mocap_file("asfamc/49_10.amc")
    library = tmp_path / "library"
    add_step(library, request_entry(source, {"name": "fold", "bpm": 90.0, "first_beat_s": 0.5}))
    assert sorted(path.name for path in library.iterdir()) == ["49.asf", "49_10.amc", "49_10.toml"]
    assert load_folder(library)[0].step == "fold"
    lonely = tmp_path / "lonely.amc"
    lonely.write_bytes(source.read_bytes())
    with pytest.raises(RecordingError, match=r"lonely\.amc: its skeleton is not known"):
        request_entry(lonely, {"name": "fold", "bpm": 90.0, "first_beat_s": 0.5})


@pytest.mark.long
@pytest.mark.shared
def test_file_is_exported_with_named_skeleton(tmp_path: Path) -> None:
    path, skeleton = mocap_file("asfamc/49_10.amc"), mocap_file("asfamc/49.asf")
    out = tmp_path / "out.glb"
    done = run_live("export", str(path), "--to", str(out), "--skeleton", str(skeleton))
    assert done.returncode == 0, done.stderr
    clip = retarget(read_motion(path, skeleton=skeleton), name="dance")
    np.testing.assert_allclose(read_joints(out), joint_positions(clip), atol=1e-5)


@pytest.mark.shared
def test_file_is_reported() -> None:
    done = run_live("bvh", str(mocap_file("asfamc/49_14.amc")), "--json")
    facts = json.loads(done.stdout)
    assert (list(facts), facts["up"]) == (KEYS.split(), "Y")
    assert 1.5 < facts["height_m"] < 1.9


def test_readme_lists_the_format() -> None:
    text = Path(__file__).with_name("README.md").read_text(encoding="utf-8")
    assert f"| {FORMAT.name} | `{FORMAT.suffixes[0]}` | {FORMAT.text} |\n" in text


def test_file_is_refused_without_this_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion_formats, "_modules", list)
    installed_formats.cache_clear()
    try:
        (tmp_path / "a.amc").write_text(AMC)
        with pytest.raises(MotionFileError, match=r"no reader for \.amc files is installed; there are BVH"):
            read_motion(tmp_path / "a.amc")
    finally:
        installed_formats.cache_clear()


def read_amc(data: bytes) -> SourceMotion:
    return parse_amc(data, "x", SKELETON)


def read_asf(data: bytes) -> SourceMotion:
    return parse_amc(AMC.encode(), "x", parse_asf(data, "x"))


HOSTILE: dict[str, tuple[Callable[[bytes], SourceMotion], Callable[[], str]]] = {
    "frames without bones": (read_amc, lambda: "".join(f"{n}\n" for n in range(500_000))),
    "blank lines in an amc": (read_amc, lambda: "\n" * 4_000_000),
    "comments in an amc": (read_amc, lambda: "#\n" * 1_000_000),
    "one line in an amc": (read_amc, lambda: "root " + "1 " * 2_000_000),
    "many frames": (
        read_amc,
        lambda: "".join(f"{n}\nroot 0 0 0 0 0 0\nthigh 0 0 0\nshin 0\n" for n in range(1, 8_000)),
    ),
    "gaps everywhere": (
        read_amc,
        lambda: "".join(f"{2 * n}\nroot 0 0 0 0 0 0\nthigh 0 0 0\nshin 0\n" for n in range(1, 3000)),
    ),
    "bones without end": (read_asf, lambda: ":version\n:bonedata\n" + "begin\nlength 1\n" * 200_000),
    "bones without names": (read_asf, lambda: ":version\n:bonedata\n" + "begin\nend\n" * 200_000),
    "more bones than there may be": (
        read_asf,
        lambda: ":version\n:bonedata\n" + "".join(f"begin\nname b{n}\nend\n" for n in range(2000)),
    ),
    "a large skeleton": (read_asf, lambda: "#" * 5_000_000),
}


@pytest.mark.long
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_file_takes_little_memory_and_time(name: str) -> None:
    read, make = HOSTILE[name]
    read_limited(read, make().encode())


@mostly_long("seed", range(4), quick=[0])
def test_mutated_acclaim_file_gives_motion_or_error(seed: int) -> None:
    rng = random.Random(seed)
    outcomes = {"motion": 0, "error": 0}
    for turn in range(400):
        asf, amc = (mutate_text(ASF, rng), AMC) if turn % 2 else (ASF, mutate_text(AMC, rng))
        found, problem = attempt(lambda asf=asf, amc=amc: parse_amc(amc.encode(), "x", parse_asf(asf.encode(), "x")))
        if found is None:
            assert isinstance(problem, MotionFileError)
            assert "\n" not in str(problem)
            assert len(str(problem)) < 400
            outcomes["error"] += 1
            continue
        outcomes["motion"] += 1
        assert found.rotation.shape == (found.frame_count, found.joint_count, 4)
        assert np.isfinite(found.translation).all()
        np.testing.assert_allclose(np.linalg.norm(found.rotation, axis=-1), 1.0, atol=1e-9)
        assert (found.parents[1:] < np.arange(1, found.joint_count)).all()
        assert 1e-4 <= found.frame_time <= 10.0
    assert min(outcomes.values()) > 20, outcomes


@pytest.mark.shared
@mostly_long("seed", range(3), quick=[1])
def test_mutated_recording_gives_clip_or_error(seed: int) -> None:
    rng = random.Random(seed)
    asf = mocap_file("asfamc/49.asf").read_text()
    amc = mocap_file("asfamc/49_14.amc").read_text()
    amc = amc[: amc.index("\n7\n") + 1]
    outcomes = {"clip": 0, "error": 0}
    for turn in range(40):
        skeleton, motion = (mutate_text(asf, rng), amc) if turn % 2 else (asf, mutate_text(amc, rng))
        clip, problem = attempt(
            lambda s=skeleton, m=motion: retarget(parse_amc(m.encode(), "x", parse_asf(s.encode(), "x")), name="x")
        )
        outcomes["clip" if clip is not None else "error"] += 1
        assert clip is None or np.isfinite(clip.root_position).all()
        assert problem is None or "\n" not in str(problem)
    assert min(outcomes.values()) > 0, outcomes
