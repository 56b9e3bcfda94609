"""What `live partner` does: files in, a search, files out."""

import json
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, cast

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.cli.partner_path import Led, led_by_path
from live.cli.whole_file import write_whole
from live.motion.body_tracks import body_tracks
from live.motion.bvh.writer import write_bvh
from live.motion.clip import Clip
from live.motion.editing.sampling import read_clip
from live.motion.example.cloud import ends_cloud
from live.motion.example.cluster import thin_out
from live.motion.example.enforce import hold_error
from live.motion.example.leash import NEAR
from live.motion.example.partner import (
    WALK_CONTINUITY,
    WALK_RATE,
    WALK_STRETCH,
    Partnered,
    Search,
    find_partner,
    shown_beats,
)
from live.motion.example.transcript import transcribed, transcript_text
from live.motion.example.truth import errors, joints_of, slide
from live.motion.example.units import BEATS_OF_UNIT, Units, beat_samples
from live.motion.file_error import MotionFileError
from live.motion.quality.beats import offsets
from live.motion.quality.smoothness import at_samples, half_width, largest_around, p99_of_raw
from live.motion.run_in import find_beginning
from live.motion.tempo_guess import guess_tempo
from live.motion.two_beats import CLEAR, two_beat_lines
from live.steps.motion_file import read_motion
from live.steps.pairs import Side
from live.steps.pairs_file import Examples, read_pairs, recorded

FEWEST: Final = 8
"""Frames below which a file holds no dance."""


@dataclass(frozen=True, slots=True)
class Wish:
    """The options of the command, checked one by one."""

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


def run(wish: Wish) -> None:
    """Everything."""
    known = read_pairs(wish.examples)
    walks = known.leaders[0] is None
    if walks != (wish.path is not None):
        kind = "walks, which a path leads" if walks else "pairs, which a leader's motion leads"
        raise PersonError(f"{wish.examples} holds {kind}", "--path PATH.csv" if walks else "LEADER.bvh")
    units, kept = known.units, known.units.count
    if wish.cluster is not None:
        units = thin_out(units, wish.cluster, seed=wish.seed)
    if wish.path is not None:
        led, x = led_by_path(wish.path, 0.15 if wish.smooth is None else wish.smooth)
    else:
        assert wish.leader is not None  # checked with the options
        led = read_leader(wish.leader, wish, known)
        x = ends_cloud(led.recorded.clip)
    search = _search(wish, led, known, walks)
    clip = led.recorded.clip
    if wish.online:
        from live.motion.example.live_partner import find_live

        found, timing = find_live(clip, x, units, search, time.thread_time)
    else:
        found, timing = find_partner(clip, x, units, search, time.perf_counter), {}
    out = _beside(found.clip, led)
    write_whole(write_bvh(out, rate=None).encode(), wish.out, "--out")
    told = report_of(found, units, led, search, wish) | timing | {"units_in_examples": kept, "units_used": units.count}
    if wish.truth is not None:
        told["truth"] = compared(found, led, wish)
    if wish.transcript is not None:
        text = transcript_text(transcribed(found.reading, units))
        write_whole(text.encode(), wish.transcript, "--transcript")
    if wish.report is not None:
        write_whole((json.dumps(told, indent=1) + "\n").encode(), wish.report, "--report")
    _say(told, wish)


def read_leader(path: Path, wish: Wish, known: Examples) -> Led:
    """The leader's motion; where nothing is said of its rate, it is taken for what recordings like it were."""
    try:
        motion = read_motion(path)
        fps = wish.fps or likely_fps(motion.header_fps, known)
        drop = wish.drop_frames
        if drop is None:
            drop = find_beginning(body_tracks(motion, fps=fps)).drop_frames
        if motion.frame_count - drop < FEWEST:
            raise PersonError(f"{path}: {max(motion.frame_count - drop, 0)} frames; {FEWEST} at least expected")
        return Led(recorded(motion, Side(file=path.name, fps=fps, drop_frames=drop)), drop)
    except (MotionFileError, ValueError) as error:
        raise PersonError(str(error)) from None


def likely_fps(header: float, known: Examples) -> float:
    """The true rate of a file whose header says `header`: where all examples with that header are corrected alike, so
    is this one, for files of one source lie alike."""
    like = {
        one.fps for one in (*known.leaders, *known.followers)
        if one is not None and abs(one.header_fps / header - 1.0) < 1e-3
    }  # fmt: skip
    return like.pop() if len(like) == 1 else header


def _search(wish: Wish, led: Led, known: Examples, walks: bool) -> Search:
    default = Search(rate=WALK_RATE, stretch=WALK_STRETCH, k=WALK_CONTINUITY, near=NEAR) if walks else Search()
    search = replace(
        default,
        rate=default.rate if wish.rate is None else wish.rate,
        stretch=default.stretch if wish.stretch is None else wish.stretch,
        k=default.k if wish.k is None else wish.k,
        beam=default.beam if wish.beam is None else wish.beam,
    )
    smoothing = cast(Literal["none", "linear", "eased"], wish.smoothing)
    search = replace(search, smoothing=smoothing, hold_feet=wish.hold_feet)
    beats = _beats(wish, led, known)
    return search if beats is None else replace(search, beats=beats)


def _beats(wish: Wish, led: Led, known: Examples) -> npt.NDArray[np.float64] | None:
    """When the leader's beats are [s]: as given; as her feet have them, where that is clear; else, where they are
    needed, guessed."""
    clip = led.recorded.clip
    last = (clip.sample_count - 1.0) / clip.sample_rate
    if wish.bpm is not None and wish.first_beat is not None:
        return beat_samples(60.0 / wish.bpm, wish.first_beat, 1.0, last)
    if wish.path is not None:
        return None
    if known.wanted.unit_beats == BEATS_OF_UNIT and all(len(one.beats) for one in known.units.examples):
        two_beats = float(np.median(known.units.seconds))
        followed = two_beat_lines([clip], two_beats if wish.bpm is None else 120.0 / wish.bpm)
        if followed is not None and followed.strength >= CLEAR:
            return followed.beats(last)
    if not wish.online:
        return None
    guess = guess_tempo(clip)
    if guess is None:
        raise PersonError("the leader's beats cannot be guessed", "--bpm BPM --first-beat SECONDS")
    return beat_samples(60.0 / guess.reference.bpm, guess.reference.first_beat_s, 1.0, last)


def _beside(clip: Clip, led: Led) -> Clip:
    """The follower frame by frame beside the leader's file: frames that were left out hold the first pose."""
    frames = np.maximum(np.arange(led.recorded.frames + led.dropped) - led.dropped, 0)
    root, rotation, contact = read_clip(clip, frames * clip.sample_rate / led.recorded.fps)
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32),
        led.recorded.fps, np.ascontiguousarray(contact),
    )  # fmt: skip


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


def _say(told: dict[str, Any], wish: Wish) -> None:
    spent = ", ".join(f"{key} {value:.2f} s" for key, value in told["seconds"].items())
    print(f"{wish.out}: {len(told['units'])} units for {told['frames'] / told['fps']:.1f} s ({spent})")
    if "truth" in told:
        figures = told["truth"]
        print(
            f"against {wish.truth}: joints {figures['joint_error_m']:.3f} m off "
            f"({figures['joint_error_aligned_m']:.3f} m aligned), distance {figures['hip_distance_error_m']:.3f} m off"
        )
