"""Options of `live partner`, a drawn path as the leader of a walk (H019), and the metrics of the follower found."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.library.motion_file import read_motion
from live.library.partner_pairs import RecordedSide, Side, retarget_side
from live.motion.clip import Clip
from live.motion.formats.file_error import MotionFileError
from live.motion.partner.answer import hold_error
from live.motion.partner.evaluation import follower_errors, joint_positions, slide_metrics
from live.motion.partner.partner_synthesis import PartnerResult, SearchSettings, shown_beats
from live.motion.partner.path_leader import frenet_cloud
from live.motion.partner.point_clouds import Cloud, path_cloud
from live.motion.partner.step_phase import phase_at_turns, phase_difference, phase_values, pooled
from live.motion.partner.units import Units
from live.motion.quality.metrics import beat_offsets, half_width, largest_around, largest_at_samples, raw_p99
from live.motion.retarget.retarget import SAMPLE_RATE
from live.motion.skeleton import JOINT_COUNT, SKELETON

MAX_BYTES: Final = 50_000_000
MAX_SECONDS: Final = 3600.0
"""Maximum duration of a path [s]."""
MAX_COORDINATE: Final = 1000.0
"""Maximum coordinate of a path [m]."""
MAX_WALK_SPEED: Final = 3.0
"""Maximum walking speed [m/s]."""


@dataclass(frozen=True, slots=True, eq=False)
class LeaderMotion:
    """A leader on the engine's skeleton."""

    recorded: RecordedSide
    dropped: int
    """Number of dropped leading frames."""


def leader_from_path(path: Path, smooth: float) -> tuple[LeaderMotion, Cloud]:
    """Return a leader who glides along the path, and their control cloud."""
    time, place = read_path(path)
    cloud = frenet_cloud(time, place, SAMPLE_RATE, smooth=smooth)
    middle = cloud.floor.mean(axis=1)
    speed = np.abs(np.diff(middle)) * SAMPLE_RATE
    if speed.size and float(np.percentile(speed, 90)) > MAX_WALK_SPEED:
        raise PersonError(
            f"{path}: {np.percentile(speed, 90):.1f} m/s; nobody walks faster than {MAX_WALK_SPEED:g} m/s",
            "perform the path at the speed of a walk; times are in s, places in m",
        )
    root = np.zeros((cloud.count, 3), np.float32)
    root[:, 0], root[:, 1], root[:, 2] = middle.imag, SKELETON.rest_positions()[0, 1], middle.real
    rotation = np.zeros((cloud.count, JOINT_COUNT, 4), np.float32)
    across = (cloud.floor[:, 0] - cloud.floor[:, 1]) / 1j
    rotation[..., 0] = 1.0
    half = 0.5 * np.angle(across)
    rotation[:, 0, 0], rotation[:, 0, 2] = np.cos(half), np.sin(half)
    clip = Clip("path", root, rotation, SAMPLE_RATE, np.zeros((cloud.count, 2), np.bool_))
    return LeaderMotion(RecordedSide(clip, cloud.count, SAMPLE_RATE, SAMPLE_RATE), 0), cloud


def read_path(path: Path) -> tuple[Float64, Float64]:
    """Read times (n,) [s] and positions (n, 2), x and z [m], from a CSV file with the columns time_s, x, z.

    Raise PersonError if the file is invalid.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{path}: more than {MAX_BYTES} bytes")
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise PersonError(f"cannot read the path {path}: {error.strerror}", "--path PATH.csv") from None
    except UnicodeDecodeError:
        raise PersonError(f"{path}: not a text in UTF-8") from None
    rows: list[tuple[float, float, float]] = []
    for number, row in enumerate(csv.reader(lines), 1):
        if not row or row[0].lstrip().startswith("#"):
            continue
        try:
            time, x, z = (float(value) for value in row)
        except ValueError:
            if not rows and number == 1:
                continue  # the heading
            raise PersonError(f"{path}, line {number}: three numbers expected: time_s, x, z") from None
        if not (np.isfinite([time, x, z]).all() and max(abs(x), abs(z)) <= MAX_COORDINATE):
            raise PersonError(f"{path}, line {number}: places within {MAX_COORDINATE:g} m expected")
        if rows and time <= rows[-1][0]:
            raise PersonError(f"{path}, line {number}: time {time:g} s after {rows[-1][0]:g} s; times ascend")
        rows.append((time, x, z))
    if len(rows) < 2 or rows[-1][0] - rows[0][0] > MAX_SECONDS:
        raise PersonError(f"{path}: {len(rows)} points; two at least, over {MAX_SECONDS:g} s at most, expected")
    values = np.array(rows)
    return values[:, 0], values[:, 1:]


@dataclass(frozen=True, slots=True)
class PartnerOptions:
    """Options of the command, each checked on its own."""

    leader: Path | None
    examples: Path
    out: Path
    path: Path | None
    online: bool
    stretch: float | None
    k: float | None
    beam: float | None
    rate: float | None
    cluster: float | None
    fps: float | None
    drop_frames: int | None
    bpm: float | None
    first_beat: float | None
    smoothing: str
    hold_feet: bool
    truth: Path | None
    report: Path | None
    transcript: Path | None
    seed: int
    smooth: float | None = None
    style: str | None = None


def follower_report(
    found: PartnerResult, units: Units, led: LeaderMotion, search: SearchSettings, options: PartnerOptions
) -> dict[str, Any]:
    """Return the metrics of a follower (contracts: reports)."""
    reading, clip = found.reading, found.clip
    positions = joint_positions(clip)
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
        **slide_metrics(positions, found.answer.clip.contact, clip.sample_rate),
        "hand_hold_error_m": hold_error(clip, led.recorded.clip, found.answer.holds) if not options.path else None,
        "beat_offset_ms": _beat_figures(found, units, search),
        "phase_at_turns": _phase_figures(found, units, led) if options.path else None,
    }  # fmt: skip
    return told | (_join_figures(found, positions, units) if options.report is not None else {})


def _phase_figures(found: PartnerResult, units: Units, led: LeaderMotion) -> dict[str, Any]:
    """Return the phases of the steps at sharp turns of a path, in the answer and in the recordings (H018)."""
    recorded = pooled([phase_at_turns(one.follower, one.control) for one in units.examples])
    answered = phase_at_turns(found.clip, path_cloud(led.recorded.clip))
    apart = phase_difference(answered, recorded) if answered.count and recorded.count else None
    return {
        "answer": phase_values(answered), "recordings": phase_values(recorded), "difference_cycles": apart
    }  # fmt: skip


def _join_figures(found: PartnerResult, positions: npt.NDArray[np.float64], units: Units) -> dict[str, float | None]:
    """Return velocity and acceleration at joins relative to the raw recordings (contracts: join ratios)."""
    rate, half = found.clip.sample_rate, half_width(0.0)
    used = {int(units.example[unit]) for unit in found.reading.unit}
    raw = [largest_at_samples(joint_positions(units.examples[one].follower), rate) for one in sorted(used)]
    middle = found.answer.boundaries / rate
    told: dict[str, float | None] = {}
    for n, name in enumerate(("join_velocity_ratio", "join_acceleration_ratio")):
        usual = raw_p99([one[n] for one in raw], half, rate)
        around = largest_around(largest_at_samples(positions, rate)[n], middle, half, rate)
        told[name] = float(np.percentile(around, 99)) / usual if around.size and usual > 0.0 else None
    return told


def _beat_figures(found: PartnerResult, units: Units, search: SearchSettings) -> dict[str, Any] | None:
    """Return statistics of each annotated beat's shown time minus the leader's nearest beat."""
    if search.beats is None or len(search.beats) < 2:
        return None
    shown = shown_beats(found.answer, found.reading, units)
    if not len(shown):
        return None
    away = np.abs(beat_offsets(shown, search.beats)) * 1000.0
    return {"annotated": {"median": float(np.median(away)), "p95": float(np.percentile(away, 95))}}


def compare_with_truth(found: PartnerResult, led: LeaderMotion, options: PartnerOptions) -> dict[str, Any]:
    """Return errors against the real follower, whose file matches the leader's frame by frame."""
    assert options.truth is not None  # checked by the caller
    try:
        motion = read_motion(options.truth)
        side = Side(file=options.truth.name, fps=led.recorded.fps, drop_frames=min(led.dropped, motion.frame_count - 1))
        real = retarget_side(motion, side)
    except (MotionFileError, ValueError) as error:
        raise PersonError(str(error)) from None
    if real.frames != led.recorded.frames:
        raise PersonError(
            f"--truth {options.truth}: {real.frames + led.dropped} frames, the leader has "
            f"{led.recorded.frames + led.dropped}",
            "the follower of the same take",
        )
    rate = found.clip.sample_rate
    truth = joint_positions(real.clip)
    one = follower_errors(joint_positions(found.clip), truth, joint_positions(led.recorded.clip), rate)
    return {
        "joint_error_m": one.joint_m, "joint_error_aligned_m": one.aligned_m,
        "hip_distance_error_m": one.hip_distance_m, "velocity_error_m_s": one.velocity_m_s,
        "foot_slide_mean_of_truth": slide_metrics(truth, real.clip.contact, rate)["foot_slide_mean"],
    }  # fmt: skip
