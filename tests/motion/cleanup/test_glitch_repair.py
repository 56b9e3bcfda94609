"""Tests of tracking glitch repair: lost frames are restored closely and other frames stay unchanged."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from live.motion.cleanup.glitch_detection import find_glitches
from live.motion.cleanup.glitch_repair import Repair, repair
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.formats.source_motion import SourceMotion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.retarget import retarget
from live.motion.skeleton import SKELETON
from tests.fixtures.mocap import mocap_motion
from tests.fixtures.mostly_long import mostly_long
from tests.motion.retarget.made_source import NAMES, moving_values, source


def repair_motion(motion: SourceMotion, fps: float | None = None) -> tuple[SourceMotion, list[Repair]]:
    tracks = body_tracks(motion, fps=fps)
    start = find_recording_start(tracks).drop_frames
    result, report = repair(motion, find_glitches(tracks, motion.parents, start), fps=fps)
    after = body_tracks(result, fps=fps)
    if all(one.done for one in report):
        assert find_glitches(after, result.parents, start) == []
    return result, report


def largest_turn(a: SourceMotion, b: SourceMotion) -> float:
    """Largest angle between the rotations of two motions [degrees]."""
    dot = np.abs(np.sum(a.rotation * b.rotation, axis=-1))
    return float(np.degrees(2.0 * np.arccos(np.clip(dot, 0.0, 1.0)).max()))


def test_clean_dance_is_unchanged() -> None:
    motion = source(moving_values(4.0, 60.0), 60.0)
    result, report = repair_motion(motion)
    assert report == []
    assert result is motion


@pytest.mark.parametrize("length", [1, 3, 6])
def test_lost_frames_are_restored(length: int) -> None:
    truth = source(moving_values(6.0, 60.0), 60.0)
    lost = slice(150, 150 + length)
    rotation, translation = truth.rotation.copy(), truth.translation.copy()
    rotation[lost] = (1.0, 0.0, 0.0, 0.0)
    translation[lost, 0] = 0.0
    result, (report,) = repair_motion(replace(truth, rotation=rotation, translation=translation))
    assert report.done
    assert (report.first_frame, report.last_frame) == (149, 150 + length)
    assert largest_turn(result, truth) < 2.5
    assert np.abs(result.translation - truth.translation).max() < 0.6
    outside = [frame for frame in range(truth.frame_count) if not 149 <= frame <= 150 + length]
    np.testing.assert_array_equal(result.rotation[outside], truth.rotation[outside])
    np.testing.assert_array_equal(result.translation[outside], truth.translation[outside])


def test_repair_changes_only_faulty_limb() -> None:
    truth = source(moving_values(6.0, 60.0), 60.0)
    rotation = truth.rotation.copy()
    arm = NAMES.index("RightArm")
    turn = Rotation.from_euler("Y", 80.0, degrees=True)
    rotation[200:202, arm] = (Rotation.from_quat(rotation[200:202, arm][:, [1, 2, 3, 0]]) * turn).as_quat()[
        :, [3, 0, 1, 2]
    ]
    result, (report,) = repair_motion(replace(truth, rotation=rotation))
    assert set(report.joints) == {"RightArm", "RightForeArm", "RightHand"}
    others = [j for j, name in enumerate(NAMES) if name not in report.joints]
    np.testing.assert_array_equal(result.rotation[:, others], truth.rotation[:, others])
    assert largest_turn(result, truth) < 2.0
    np.testing.assert_allclose(np.linalg.norm(result.rotation, axis=-1), 1.0, atol=1e-12)


def test_joint_above_hips_is_repaired() -> None:
    """Some files keep the hips still under a root that travels."""
    truth = source(moving_values(6.0, 60.0), 60.0)
    root = np.tile((1.0, 0.0, 0.0, 0.0), (truth.frame_count, 1, 1))
    carried = replace(
        truth,
        names=("Reference", *truth.names),
        parents=np.concatenate(([-1], truth.parents + 1)).astype(np.int32),
        offsets=np.concatenate((np.zeros((1, 3)), truth.offsets)),
        end_parents=truth.end_parents + 1,
        translation=np.concatenate((truth.translation[:, :1], 0.0 * root[..., 1:], truth.translation[:, 1:]), axis=1),
        rotation=np.concatenate((root, truth.rotation), axis=1),
    )
    translation = carried.translation.copy()
    translation[150, 0] += (45.0, 0.0, 0.0)
    result, (report,) = repair_motion(replace(carried, translation=translation))
    assert report.done
    assert np.abs(result.translation - carried.translation).max() < 0.6


def test_long_gap_is_not_repaired() -> None:
    motion = source(moving_values(6.0, 60.0), 60.0)
    rotation, translation = motion.rotation.copy(), motion.translation.copy()
    for joint in ("UpLeg", "Leg", "Foot", "ToeBase"):
        left, right = NAMES.index("Left" + joint), NAMES.index("Right" + joint)
        for array in (rotation, translation):
            array[100:200, [left, right]] = array[100:200, [right, left]]
    swapped = replace(motion, rotation=rotation, translation=translation)
    result, (report,) = repair_motion(swapped)
    assert not report.done
    assert result is swapped
    assert "too long" in report.note


def test_glitch_at_end_is_not_repaired() -> None:
    motion = source(moving_values(3.0, 60.0), 60.0)
    translation = motion.translation.copy()
    translation[-2:, 0] += (50.0, 0.0, 0.0)
    _, (report,) = repair_motion(replace(motion, translation=translation))
    assert not report.done
    assert "end" in report.note


@pytest.mark.shared
@mostly_long(("take", "count"), [("03", 1), ("04", 3), ("05", 2), ("06", 1)], quick=[1])
def test_salsa_recordings_are_repaired(take: str, count: int) -> None:
    """The feet's pops of up to 2,800 m/s² are in the recording; repaired, nothing is beyond the clean takes' 320."""
    motion = mocap_motion(f"salsa/60_{take}.bvh")
    result, report = repair_motion(motion, 60.0)
    assert [one.done for one in report] == [True] * count
    assert sum(one.last_frame - one.first_frame + 1 for one in report) <= 18
    assert all(len(one.joints) == motion.joint_count for one in report)
    clip = retarget(result, name=take, fps=60.0, drop_frames=6)
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    feet = [SKELETON.index(side + joint) for side in ("left", "right") for joint in ("Foot", "Toes")]
    assert np.linalg.norm(np.diff(positions[:, feet], 2, axis=0), axis=-1).max() * 3600.0 < 340.0
    assert result.file == motion.file
