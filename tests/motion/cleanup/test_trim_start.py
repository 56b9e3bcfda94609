"""How recordings begin: added T-poses and the run-in from them."""

import numpy as np
import pytest

from live.motion.cleanup.trim_start import RecordingStart, find_recording_start
from live.motion.retarget.body_tracks import body_tracks
from tests.fixtures.mocap import mocap_index, mocap_motion
from tests.motion.retarget.made_source import lively, source, still


def beginning(values: np.ndarray, fps: float) -> RecordingStart:
    return find_recording_start(body_tracks(source(values, fps)))


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_dance_has_nothing_before_it(fps: float) -> None:
    assert beginning(lively(4.0, fps), fps) == RecordingStart(False, 0)


def test_a_t_pose_is_one_frame() -> None:
    dance = lively(4.0, 60.0)
    dance[:, 0] += 100.0
    assert beginning(np.concatenate((still(1), dance)), 60.0) == RecordingStart(True, 1)


def test_the_run_in_from_it_ends_where_the_body_is_slowest() -> None:
    dance = lively(4.0, 60.0)
    way = (1.0 - np.array([0.5, 0.7, 0.85, 0.95, 1.0]))[:, None]
    run_in = dance[0] + way * (still(1)[0] - dance[0]) + way * np.eye(1, dance.shape[1]) * 120.0
    assert beginning(np.concatenate((still(1), run_in, dance[1:])), 60.0) == RecordingStart(True, 6)


def test_somebody_who_stands_with_arms_out_is_not_dropped() -> None:
    values = still(240)
    values[:, 0] = 20.0 * np.sin(np.arange(240) / 40.0)
    assert beginning(values, 60.0) == RecordingStart(False, 0)


@pytest.mark.shared
@pytest.mark.parametrize(
    "row",
    [row for row in mocap_index() if not row["file"].startswith("edge/")],
    ids=lambda row: str(row["file"]),
)
def test_recordings(row: dict[str, object]) -> None:
    """T-poses as index.json has them; salsa and Indian dance run in for five frames more (INDEX.md, trap 2)."""
    name = str(row["file"])
    found = find_recording_start(body_tracks(mocap_motion(name), fps=60.0 if name.startswith("salsa") else None))
    assert found.t_pose_first == row["tpose_first_frame"]
    run_in = name.startswith(("salsa", "solo/indian"))
    assert found.drop_frames == (6 if run_in else int(found.t_pose_first))
