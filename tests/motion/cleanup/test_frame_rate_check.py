"""Tests of the suspicion of a wrong frame rate: swings of known duration, and recordings at right and wrong rates."""

from pathlib import Path

import numpy as np
import pytest

from live.library.beat_alignment import SyncRequest, find_sync
from live.library.motion_file import read_motion
from live.motion.cleanup.frame_rate_check import suspect_frame_rate, swing_durations
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.formats.file_report import analyze_motion
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.body_tracks import body_tracks
from tests.fixtures.mocap import mocap_motion
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh
from tests.motion.retarget.made_source import source, still

RIGHT = {
    **{f"salsa/{who}_0{take}.bvh": 60.0 for who in (60, 61) for take in (1, 2, 3, 4)},
    **{f"solo/modern05/05_{take}.bvh": 120.0 for take in ("02", "06", "09", "13", "14", "18")},
    "walk/cmu_12_01_walk.bvh": 120.0, "group/perfume_aachan.bvh": 40.0, "solo/indian94/indian_06.bvh": 120.0,
}  # fmt: skip


def striding(swing_s: float, rate: float, *, way_cm: float = 50.0, seconds: float = 8.0) -> np.ndarray:
    """A body that is carried over the floor in strides of `way_cm` that each take `swing_s` and are half a second
    apart; its feet go with it, at a speed of a half sine."""
    time = np.arange(round(seconds * rate)) / rate
    stride, part = np.divmod(time, 0.5 + swing_s)
    moved = stride + 0.5 * (1.0 - np.cos(np.pi * np.clip(part / swing_s, 0.0, 1.0)))
    values = still(len(time))
    values[:, 2] = way_cm * moved
    return values


@pytest.mark.parametrize("rate", [30.0, 60.0, 120.0])
@pytest.mark.parametrize("swing", [0.2, 0.4])
def test_durations_of_swings_are_measured(rate: float, swing: float) -> None:
    """A half sine is over 0.3 of its peak for 0.806 of its time; the smoothing adds little."""
    tracks = body_tracks(source(striding(swing, rate), rate))
    for side in (0, 1):
        found = swing_durations(tracks.ankles[:, side], tracks.rate)
        assert 8 <= len(found) <= 12
        assert np.median(found) == pytest.approx(0.806 * swing, abs=0.4 / rate + 0.008)


@pytest.mark.parametrize(("swing", "suspected"), [(0.9, False), (0.3, True)])
def test_limit_is_that_of_legs(swing: float, suspected: bool) -> None:
    found = suspect_frame_rate(body_tracks(source(striding(swing, 120.0), 120.0)))
    assert (found is not None) == suspected
    if found is not None:
        assert "is the true rate 60 (fps)?" in str(found)


def test_small_steps_few_steps_and_standing_are_not_suspected() -> None:
    for values in (striding(0.15, 60.0, way_cm=10.0), striding(0.15, 60.0, seconds=1.2), still(600)):
        assert suspect_frame_rate(body_tracks(source(values, 60.0))) is None


def test_suspicion_is_said_unless_rate_is_given(tmp_path: Path) -> None:
    path = tmp_path / "fast.bvh"
    path.write_text(body_bvh(striding(0.2, 120.0), fps=120.0))
    assert "is the true rate 60" in find_sync(SyncRequest(path, anchor_s=0.0, bpm=100.0)).doubt
    assert find_sync(SyncRequest(path, fps=60.0, anchor_s=0.0, bpm=100.0)).doubt == ""
    told = [warning.what for warning in analyze_motion(read_motion(path))[0].warnings]
    assert any("is the true rate 60" in words for words in told)


def suspicion_at(motion: SourceMotion, rate: float) -> bool:
    tracks = body_tracks(motion, fps=rate)
    return suspect_frame_rate(tracks, find_recording_start(tracks).drop_frames) is not None


@pytest.mark.shared
@mostly_long("name", RIGHT, quick=range(0, len(RIGHT), 3))
def test_only_wrong_rates_of_recordings_are_suspected(name: str) -> None:
    motion = mocap_motion(name)
    assert not suspicion_at(motion, RIGHT[name])
    if "salsa" in name:  # the header says 120
        assert suspicion_at(motion, motion.header_fps)
