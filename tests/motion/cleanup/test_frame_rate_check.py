"""Tests of the suspicion of a wrong frame rate: known accelerations, and recordings at right and wrong rates."""

from pathlib import Path

import numpy as np
import pytest

from live.library.beat_alignment import SyncRequest, find_sync
from live.library.motion_file import read_motion
from live.motion.cleanup.frame_rate_check import RESTLESS, suspect_frame_rate
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.formats.file_report import analyze_motion
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from tests.fixtures.mocap import mocap_motion
from tests.motion.formats.made_bvh import body_bvh
from tests.motion.retarget.made_source import source, still

RIGHT = {
    **{f"salsa/{who}_0{take}.bvh": 60.0 for who in (60, 61) for take in (1, 2, 3, 4)},
    **{f"solo/modern05/05_{take}.bvh": 120.0 for take in ("02", "06", "09", "13", "14", "18")},
    "walk/cmu_12_01_walk.bvh": 120.0, "group/perfume_aachan.bvh": 40.0, "solo/indian94/indian_06.bvh": 120.0,
}  # fmt: skip


def circling(acceleration: float, rate: float, seconds: float = 4.0) -> np.ndarray:
    """A body that is carried round a circle of 20 cm, hips and feet with this constant acceleration [m/s²]."""
    values = still(round(seconds * rate))
    turn = np.sqrt(acceleration / 0.2) * np.arange(len(values)) / rate
    values[:, 0], values[:, 2] = 20.0 * np.cos(turn), 20.0 * np.sin(turn)
    return values


def test_accelerations_are_measured() -> None:
    found = suspect_frame_rate(body_tracks(source(circling(30.0, 120.0), 120.0)))
    assert found is not None
    passed = np.exp(-0.5 * (0.02**2) * 30.0 / 0.2)  # of a circle by the smoothing
    assert (found.hips, found.feet) == pytest.approx((30.0 * passed, 30.0 * passed), rel=0.02)
    assert "is the true rate 60 (fps)?" in str(found)


@pytest.mark.parametrize(("share", "suspected"), [(0.9, False), (1.2, True)])
def test_limit_is_that_of_dancers(share: float, suspected: bool) -> None:
    motion = source(circling(share * RESTLESS, 120.0), 120.0)
    assert (suspect_frame_rate(body_tracks(motion)) is not None) == suspected


def test_single_jump_and_standing_body_are_not_suspected() -> None:
    assert suspect_frame_rate(body_tracks(source(circling(60.0, 60.0, seconds=1.5), 60.0))) is None
    assert suspect_frame_rate(body_tracks(source(still(600), 60.0))) is None


def test_suspicion_is_said_unless_rate_is_given(tmp_path: Path) -> None:
    path = tmp_path / "fast.bvh"
    path.write_text(body_bvh(circling(40.0, 120.0), fps=120.0))
    assert "is the true rate 60" in find_sync(SyncRequest(path, anchor_s=0.0, bpm=100.0)).doubt
    assert find_sync(SyncRequest(path, fps=60.0, anchor_s=0.0, bpm=100.0)).doubt == ""
    told = [warning.what for warning in analyze_motion(read_motion(path))[0].warnings]
    assert any("is the true rate 60" in words for words in told)


def suspicion_at(motion: SourceMotion, rate: float) -> bool:
    tracks = body_tracks(motion, fps=rate)
    return suspect_frame_rate(tracks, find_recording_start(tracks).drop_frames) is not None


@pytest.mark.shared
@pytest.mark.parametrize("name", RIGHT)
def test_only_wrong_rates_of_recordings_are_suspected(name: str) -> None:
    motion = mocap_motion(name)
    assert not suspicion_at(motion, RIGHT[name])
    if "salsa" in name:  # the header says 120
        assert suspicion_at(motion, motion.header_fps)
