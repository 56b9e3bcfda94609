"""Execution of `live partner`: reads files, searches the follower's motion, writes files."""

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, Literal, cast

import numpy as np
import numpy.typing as npt

from live.app.offline.partner_request import Led, Wish, compared, led_by_path, report_of
from live.app.whole_file import write_whole
from live.base.errors import PersonError
from live.library.motion_file import read_motion
from live.library.partner_pairs import Examples, Side, read_pairs, recorded
from live.motion.beats.tempo_estimation import CLEAR, guess_tempo, two_beat_lines
from live.motion.cleanup.trim_start import find_beginning
from live.motion.clip import Clip, read_clip
from live.motion.formats.bvh_writer import write_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.partner.partner_synthesis import (
    WALK_CONTINUITY,
    WALK_RATE,
    WALK_STRETCH,
    Search,
    find_partner,
)
from live.motion.partner.path_leader import NEAR
from live.motion.partner.point_clouds import ends_cloud
from live.motion.partner.transcription import transcribed, transcript_text
from live.motion.partner.units import BEATS_OF_UNIT, beat_samples, thin_out
from live.motion.retarget.body_tracks import body_tracks

FEWEST: Final = 8
"""Minimum number of frames of a leader's file."""


def run(wish: Wish) -> None:
    """Run the whole command."""
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
        from live.motion.partner_live.live_partner import find_live

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
    """Read the leader's motion; without a stated frame rate, use that of similar examples."""
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
    """Return the true frame rate of a file with rate `header` in its header.

    If all examples with that header have the same corrected rate, use it: files of one source have the same error.
    """
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
    """Return the leader's beats [s]: as given, else detected in their feet if clear, else guessed if needed."""
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
    """Resample the follower to the leader's frames; dropped leading frames hold the first pose."""
    frames = np.maximum(np.arange(led.recorded.frames + led.dropped) - led.dropped, 0)
    root, rotation, contact = read_clip(clip, frames * clip.sample_rate / led.recorded.fps)
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32),
        led.recorded.fps, np.ascontiguousarray(contact),
    )  # fmt: skip


def _say(told: dict[str, Any], wish: Wish) -> None:
    spent = ", ".join(f"{key} {value:.2f} s" for key, value in told["seconds"].items())
    print(f"{wish.out}: {len(told['units'])} units for {told['frames'] / told['fps']:.1f} s ({spent})")
    if "truth" in told:
        figures = told["truth"]
        print(
            f"against {wish.truth}: joints {figures['joint_error_m']:.3f} m off "
            f"({figures['joint_error_aligned_m']:.3f} m aligned), distance {figures['hip_distance_error_m']:.3f} m off"
        )
