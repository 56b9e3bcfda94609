"""USD files, read by USD's own library: joints, visibility, times, and what is said without it."""

import builtins
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.bridges.usd.motion_format import FORMAT
from live.library.motion_file import read_motion
from live.motion.clip import Clip
from live.motion.formats.bone_mesh import bone_mesh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.stage_motion import DancerMotion, StageMotion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quaternion import from_axis_angle, rotate
from live.motion.skeleton import JOINT_COUNT, SKELETON
from tests.fixtures.mostly_long import mostly_long

pxr = pytest.importorskip("pxr", reason="usd-core is not installed")
SAMPLES = 25


def random_dancer(name: str, seed: int, present: Any = True) -> DancerMotion:
    """A dancer with any poses."""
    chance = np.random.default_rng(seed)
    axis = chance.normal(size=(SAMPLES, JOINT_COUNT, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    rotation = from_axis_angle(axis, chance.uniform(-2.0, 2.0, (SAMPLES, JOINT_COUNT))).astype(np.float32)
    root = chance.normal(0.0, 3.0, (SAMPLES, 3)).astype(np.float32)
    clip = Clip(name, root, rotation, 30.0, np.zeros((SAMPLES, 2), np.bool_))
    return DancerMotion(name, "ember", clip, np.broadcast_to(present, (SAMPLES,)).copy(), (0.1, 0.2, 0.9))


def stage_motion() -> StageMotion:
    """Two dancers, of whom the second is there from sample 5 to 17."""
    there = (np.arange(SAMPLES) >= 5) & (np.arange(SAMPLES) < 18)
    dancers = random_dancer("dancer 1", 1), random_dancer("dancer 2", 2, there)
    return StageMotion("Night", dancers, 30.0, 0.0, np.zeros(SAMPLES), np.ones(SAMPLES))


def written(tmp_path: Path, suffix: str) -> Path:
    """The file of `stage_motion`."""
    assert FORMAT.write_stage is not None
    (data,) = FORMAT.write_stage(stage_motion(), suffix).values()
    path = tmp_path / f"night{suffix}"
    path.write_bytes(data)
    return path


@mostly_long("suffix", [".usdc", ".usda"], quick=[1])
def test_usd_reads_the_joints_where_the_dancers_have_them(tmp_path: Path, suffix: str) -> None:
    from pxr import Usd, UsdGeom, UsdSkel

    path = written(tmp_path, suffix)
    assert path.read_bytes().startswith(b"PXR-USDC" if suffix == ".usdc" else b"#usda")
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert (stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (30.0, 0.0, 24.0)
    cache = UsdSkel.Cache()
    for number, dancer in enumerate(stage_motion().dancers, start=1):
        root = UsdSkel.Root(stage.GetPrimAtPath(f"/show/dancer_{number}"))
        assert root.GetPrim().GetCustomDataByKey("group") == "ember"
        cache.Populate(root, Usd.PrimDefaultPredicate)
        skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath(f"/show/dancer_{number}/skeleton"))
        query = cache.GetSkelQuery(skeleton)
        wanted = forward_kinematics(dancer.clip.root_position, dancer.clip.rotation)[0]
        for sample in range(SAMPLES):
            matrices = query.ComputeJointSkelTransforms(sample)
            found = [matrix.ExtractTranslation() for matrix in matrices]
            np.testing.assert_allclose(np.array(found), wanted[sample], atol=1e-4)
        names = [str(joint).rpartition("/")[2] for joint in query.GetJointOrder()]
        assert names == list(SKELETON.names)
        seen = [root.ComputeVisibility(sample) == "inherited" for sample in range(SAMPLES)]
        assert seen == dancer.present.tolist()


def test_figure_is_skinned_to_the_skeleton(tmp_path: Path) -> None:
    """USD's own skinning moves each corner rigidly with its joint."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(written(tmp_path, ".usdc")))
    root = UsdSkel.Root(stage.GetPrimAtPath("/show/dancer_1"))
    before = np.array(stage.GetPrimAtPath("/show/dancer_1/figure").GetAttribute("points").Get())
    assert UsdSkel.BakeSkinning(root, pxr.Gf.Interval(3, 3))
    points = np.array(stage.GetPrimAtPath("/show/dancer_1/figure").GetAttribute("points").Get(3))
    assert points.shape == before.shape
    clip = stage_motion().dancers[0].clip
    places, turns = (each[3] for each in forward_kinematics(clip.root_position, clip.rotation)[:2])
    joint = bone_mesh().joints[:, 0]
    wanted = places[joint] + rotate(turns[joint], before - SKELETON.rest_positions()[joint])
    np.testing.assert_allclose(points, wanted, atol=1e-4)
    edges = np.linalg.norm(np.diff(points.reshape(-1, 3, 3), axis=1), axis=-1)
    wanted = np.linalg.norm(np.diff(before.reshape(-1, 3, 3), axis=1), axis=-1)
    np.testing.assert_allclose(edges, wanted, atol=1e-4)  # spindles are rigid


def test_usd_is_not_read_as_motion(tmp_path: Path) -> None:
    with pytest.raises(MotionFileError, match="USD files are not read"):
        read_motion(written(tmp_path, ".usdc"))


def test_without_usd_core_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = builtins.__import__

    def without(name: str, *arguments: Any) -> Any:
        if name.startswith("live.bridges.usd.usd_writer"):
            raise ImportError(name)
        return whole(name, *arguments)

    monkeypatch.setattr(builtins, "__import__", without)
    assert FORMAT.write_stage is not None
    with pytest.raises(PersonError, match="need the package usd-core") as raised:
        FORMAT.write_stage(stage_motion(), ".usdc")
    assert "choreographics-live[usd]" in str(raised.value.remedy)


def test_films_know_the_format() -> None:
    from live.library.motion_formats import stage_format, stage_suffixes

    assert stage_format(".USDC") is FORMAT
    assert {".usdc", ".usda", ".glb", ".bvh", ".csv", ".json"} == set(stage_suffixes())
