"""Tests of the first show as rendered: no pops, stage limits, planted feet, and steps of each group."""

from pathlib import Path

import numpy as np
import pytest

from live.show.journal.motion_report import MotionReport
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH

FPS = 60
SECONDS = 30


def dance_first_show(seconds: float):
    """The show, joint positions (F, A, J, 3) of present dancers in every frame, and the figures of the report."""
    show = load_show(Path(DEFAULT_PATCH)).start()
    view, report, frames, tick = show.view(), MotionReport(show), [], 0
    for frame in range(1, round(seconds * FPS) + 1):
        while (tick + 1) / 64 <= frame / FPS + 1 / 64:
            tick += 1
            show.tick(tick / 64)
        show.fill(view, frame / FPS + 1 / 64)
        report.frame(view)
        frames.append(view.joint_position[view.present].copy())
    return show, np.array(frames), report.result()


@pytest.fixture(scope="module")
def first_show_run():
    return dance_first_show(SECONDS)


@pytest.mark.long
def test_joint_accelerations_have_no_pops(first_show_run):
    """Jumps reach 112 m/s², and 190 when danced up to a third faster; a joint that pops shows thousands."""
    _, frames, _ = first_show_run
    acceleration = np.linalg.norm(np.diff(frames, n=2, axis=0), axis=3) * FPS * FPS
    assert acceleration.max() < 190.0
    assert np.percentile(acceleration.max(axis=(1, 2)), 50) < 30.0


@pytest.mark.long
def test_dancers_stay_on_stage_and_above_floor(first_show_run):
    show, frames, _ = first_show_run
    hips = frames[:, :, 0]
    assert np.isfinite(frames).all()
    assert np.abs(hips[..., 0]).max() < show.patch.stage.width / 2 + 0.5
    assert np.abs(hips[..., 2]).max() < show.patch.stage.depth / 2 + 0.5
    assert frames[..., 1].min() > -0.02


@pytest.mark.long
def test_dancers_gather_and_spread_with_score(first_show_run):
    """Measures 4 to 6 gather at (-2.4, 0.4), measures 7 to 10 spread."""
    _, frames, _ = first_show_run
    measure = 4 * 60 / 112

    def distance(seconds):
        return np.hypot(*(frames[int(seconds * FPS), :, 0][:, (0, 2)] - [-2.4, 0.4]).T).mean()

    assert distance(6.2 * measure) < 0.9 * distance(3 * measure)
    assert distance(10.5 * measure) > 1.1 * distance(6.5 * measure)


@pytest.mark.long
def test_feet_stay_planted_and_clips_match_beat(first_show_run):
    _, _, figures = first_show_run
    assert figures["foot_slide_mean"] < 0.12
    assert figures["beat_offset_ms"]["annotated"]["p95"] < 8.0
    assert figures["min_distance_m"] > 0.15
    assert figures["self_contact_ratio"] <= 0.01
    assert figures["neighbour_contact_ratio"] <= 0.02
    assert figures["hand_contact_ratio"] == 0.0
    steps = {row["step"] for row in figures["steps"]}
    assert {"groove", "side step", "samba", "turn", "mambo", "arm wave", "jump"} <= steps


@pytest.mark.long
def test_joins_are_smooth_and_beat_metrics_are_in_range(first_show_run):
    _, _, figures = first_show_run
    assert 0.2 < figures["join_velocity_ratio"] <= 1.0
    assert 0.2 < figures["join_acceleration_ratio"] <= 1.2
    assert 0.0 < figures["skating_ratio"] < 0.01
    assert 0.0 < figures["beat_offset_ms"]["kinematic"]["median"] < 300.0
    assert 0.2 < figures["beat_alignment"]["music"] < 1.0
    assert 0.2 < figures["beat_alignment"]["kinematic"] < 1.0
    by_chance = np.sqrt(2.0 * np.pi) * 0.05 * 112 / 60
    assert figures["beat_alignment"]["kinematic_chance"] == pytest.approx(by_chance, rel=0.02)
    assert figures["beat_alignment"]["kinematic_ratio"] > 1.1
    assert figures["beat_offset_ms"]["kinematic_chance"]["median"] > figures["beat_offset_ms"]["kinematic"]["median"]
    rows = [row for row in figures["steps"] if row["measure"] > 2]
    assert all(row["weight"] <= 1.0 for row in rows)
    assert max(row["cost"] for row in rows if row["cost"] is not None) < 0.5
    assert sum(row["cost"] is not None for row in rows) > 0.9 * len(rows)


def test_dancers_of_one_group_dance_same_step():
    """In measure 2, before travel starts, each group dances one step."""
    show, _, figures = dance_first_show(3.0)
    for group in range(3):
        members = {int(d) + 1 for d in np.flatnonzero(show.group == group)}
        rows = [row for row in figures["steps"] if row["measure"] == 2 and row["dancer"] in members]
        assert len({row["step"] for row in rows}) == 1
