"""The figures of a follower that `live partner` found, alone and beside the real one."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.cli.steps.partner_path import Led
from live.cli.steps.partner_wish import Wish
from live.library.motion_file import read_motion
from live.library.pairs import Side
from live.library.pairs_file import recorded
from live.motion.formats.file_error import MotionFileError
from live.motion.partner.enforce import hold_error
from live.motion.partner.partner_synthesis import (
    Partnered,
    Search,
    shown_beats,
)
from live.motion.partner.truth import errors, joints_of, slide
from live.motion.partner.units import Units
from live.motion.quality.beats import offsets
from live.motion.quality.smoothness import at_samples, half_width, largest_around, p99_of_raw


def report_of(found: Partnered, units: Units, led: Led, search: Search, wish: Wish) -> dict[str, Any]:
    """The figures of a follower (contracts: reports)."""
    reading, clip = found.reading, found.clip
    positions = joints_of(clip)
    gaps = [*reading.gap.tolist(), None]
    told: dict[str, Any] = {
        "units": [
            {
                "unit": units.label(int(unit)),
                "from_s": round(float(reading.start[n]) / reading.rate, 4),
                "seconds": round(float(reading.duration[n]) / reading.rate, 4),
                "recorded_seconds": round(float(units.seconds[unit]), 4),
                "distance": float(reading.distance[n]),
                "continuity": gaps[n],
            }
            for n, unit in enumerate(reading.unit)
        ],
        "score": found.coarse.score,
        "search": {
            "rate": search.rate, "stretch": search.stretch, "k": search.k,
            "beam": None if np.isinf(search.beam) else search.beam, "beats_known": search.beats is not None,
        },
        "seconds": {key: round(value, 4) for key, value in found.seconds.items()},
        "frames": led.recorded.frames + led.dropped,
        "fps": led.recorded.fps,
        "drop_frames": led.dropped,
        **slide(positions, found.answer.clip.contact, clip.sample_rate),
        "hand_hold_error_m": hold_error(clip, led.recorded.clip, found.answer.holds) if not wish.path else None,
        "beat_offset_ms": _beat_figures(found, units, search),
    }  # fmt: skip
    return told | (_join_figures(found, positions, units) if wish.report is not None else {})


def _join_figures(found: Partnered, positions: npt.NDArray[np.float64], units: Units) -> dict[str, float | None]:
    """How joins move against the raw recordings (contracts: join ratios)."""
    rate, half = found.clip.sample_rate, half_width(0.0)
    used = {int(units.example[unit]) for unit in found.reading.unit}
    raw = [at_samples(joints_of(units.examples[one].follower), rate) for one in sorted(used)]
    middle = found.answer.boundaries / rate
    told: dict[str, float | None] = {}
    for n, name in enumerate(("join_velocity_ratio", "join_acceleration_ratio")):
        usual = p99_of_raw([one[n] for one in raw], half, rate)
        around = largest_around(at_samples(positions, rate)[n], middle, half, rate)
        told[name] = float(np.percentile(around, 99)) / usual if around.size and usual > 0.0 else None
    return told


def _beat_figures(found: Partnered, units: Units, search: Search) -> dict[str, Any] | None:
    """Shown time of each annotated beat minus the leader's nearest one."""
    if search.beats is None or len(search.beats) < 2:
        return None
    shown = shown_beats(found.answer, found.reading, units)
    if not len(shown):
        return None
    away = np.abs(offsets(shown, search.beats)) * 1000.0
    return {"annotated": {"median": float(np.median(away)), "p95": float(np.percentile(away, 95))}}


def compared(found: Partnered, led: Led, wish: Wish) -> dict[str, Any]:
    """Against the real follower, whose file belongs to the leader's frame by frame."""
    assert wish.truth is not None  # asked for
    try:
        motion = read_motion(wish.truth)
        side = Side(file=wish.truth.name, fps=led.recorded.fps, drop_frames=min(led.dropped, motion.frame_count - 1))
        real = recorded(motion, side)
    except (MotionFileError, ValueError) as error:
        raise PersonError(str(error)) from None
    if real.frames != led.recorded.frames:
        raise PersonError(
            f"--truth {wish.truth}: {real.frames + led.dropped} frames, the leader has "
            f"{led.recorded.frames + led.dropped}",
            "the follower of the same take",
        )
    rate = found.clip.sample_rate
    truth = joints_of(real.clip)
    one = errors(joints_of(found.clip), truth, joints_of(led.recorded.clip), rate)
    return {
        "joint_error_m": one.joint_m, "joint_error_aligned_m": one.aligned_m,
        "hip_distance_error_m": one.hip_distance_m, "velocity_error_m_s": one.velocity_m_s,
        "foot_slide_mean_of_truth": slide(truth, real.clip.contact, rate)["foot_slide_mean"],
    }  # fmt: skip
