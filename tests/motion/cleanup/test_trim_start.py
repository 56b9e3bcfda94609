"""Tests of recording starts: added T-poses and the run-in from them."""

import numpy as np
import pytest

from live.motion.cleanup.trim_start import RecordingStart, find_recording_start
from live.motion.retarget.body_tracks import body_tracks
from tests.fixtures.mocap import mocap_index, mocap_motion
from tests.motion.retarget.made_source import moving_values, source, still


def detect_start(values: np.ndarray, fps: float) -> RecordingStart:
    return find_recording_start(body_tracks(source(values, fps)))


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_dance_without_t_pose_is_not_trimmed(fps: float) -> None:
    assert detect_start(moving_values(4.0, fps), fps) == RecordingStart(False, 0)


def test_t_pose_frame_is_dropped() -> None:
    dance = moving_values(4.0, 60.0)
    dance[:, 0] += 100.0
    assert detect_start(np.concatenate((still(1), dance)), 60.0) == RecordingStart(True, 1)


def test_run_in_ends_at_slowest_frame() -> None:
    dance = moving_values(4.0, 60.0)
    way = (1.0 - np.array([0.5, 0.7, 0.85, 0.95, 1.0]))[:, None]
    run_in = dance[0] + way * (still(1)[0] - dance[0]) + way * np.eye(1, dance.shape[1]) * 120.0
    assert detect_start(np.concatenate((still(1), run_in, dance[1:])), 60.0) == RecordingStart(True, 6)


def test_standing_dancer_with_arms_out_is_not_trimmed() -> None:
    values = still(240)
    values[:, 0] = 20.0 * np.sin(np.arange(240) / 40.0)
    assert detect_start(values, 60.0) == RecordingStart(False, 0)


@pytest.mark.shared
@pytest.mark.parametrize(
    "row",
    [row for row in mocap_index() if not row["file"].startswith("edge/")],
    ids=lambda row: str(row["file"]),
)
def test_starts_of_recordings_match_index(row: dict[str, object]) -> None:
    """T-poses as index.json has them; salsa and Indian dance run in for five frames more (INDEX.md, trap 2)."""
    name = str(row["file"])
    found = find_recording_start(body_tracks(mocap_motion(name), fps=60.0 if name.startswith("salsa") else None))
    assert found.t_pose_first == row["tpose_first_frame"]
    run_in = name.startswith(("salsa", "solo/indian"))
    assert found.drop_frames == (6 if run_in else int(found.t_pose_first))
