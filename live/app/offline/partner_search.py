"""Execution of `live partner`: reads files, searches the follower's motion, writes files."""

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, Literal, cast

import numpy as np
import numpy.typing as npt

from live.app.offline.partner_request import (
    LeaderMotion,
    PartnerOptions,
    compare_with_truth,
    follower_report,
    leader_from_path,
)
from live.base.errors import PersonError
from live.library.motion_file import read_motion
from live.library.partner_pairs import PartnerExamples, Side, read_pairs, retarget_side
from live.library.whole_file import write_atomically
from live.motion.beats.tempo_estimation import RELIABLE_STRENGTH, estimate_tempo, find_two_beat_lines
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.clip import Clip, read_clip
from live.motion.formats.bvh_writer import write_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.partner.partner_synthesis import (
    WALK_SEARCH,
    SearchSettings,
    find_partner,
)
from live.motion.partner.path_leader import MAX_DISTANCE
from live.motion.partner.point_clouds import ends_cloud, leader_cloud
from live.motion.partner.transcription import transcribe, transcript_text
from live.motion.partner.units import BEATS_OF_UNIT, beat_samples, remove_duplicates
from live.motion.partner_live.follower_filter import expected_follower
from live.motion.retarget.body_tracks import body_tracks

MIN_FRAMES: Final = 8
"""Minimum number of frames of a leader's file."""


def run_partner(options: PartnerOptions) -> None:
    """Run the whole command."""
    known = read_pairs(options.examples, style=options.style)
    walks = known.leaders[0] is None
    if walks != (options.path is not None):
        kind = "walks, which a path leads" if walks else "pairs, which a leader's motion leads"
        raise PersonError(f"{options.examples} holds {kind}", "--path PATH.csv" if walks else "LEADER.bvh")
    units, kept = known.units, known.units.count
    if options.cluster is not None:
        units = remove_duplicates(units, options.cluster, seed=options.seed)
    if options.path is not None:
        led, x = leader_from_path(options.path, 0.15 if options.smooth is None else options.smooth)
    else:
        assert options.leader is not None  # checked with the options
        led = read_leader(options.leader, options, known)
        x = ends_cloud(led.recorded.clip)
    search = _search(options, led, known, walks)
    clip = led.recorded.clip
    if options.online:
        from live.motion.partner_live.live_partner import evaluate_live

        found, timing = evaluate_live(clip, x, units, search, time.thread_time)
    else:
        expected = None if walks else expected_follower(leader_cloud(clip), units)
        found, timing = find_partner(clip, x, units, search, time.perf_counter, expected=expected), {}
    out = _resample_to_leader(found.clip, led)
    write_atomically(write_bvh(out, rate=None).encode(), options.out, "--out")
    told = (
        follower_report(found, units, led, search, options)
        | timing
        | {"units_in_examples": kept, "units_used": units.count}
    )
    if options.truth is not None:
        told["truth"] = compare_with_truth(found, led, options)
    if options.transcript is not None:
        text = transcript_text(transcribe(found.reading, units))
        write_atomically(text.encode(), options.transcript, "--transcript")
    if options.report is not None:
        write_atomically((json.dumps(told, indent=1) + "\n").encode(), options.report, "--report")
    _say(told, options)


def read_leader(path: Path, options: PartnerOptions, known: PartnerExamples) -> LeaderMotion:
    """Read the leader's motion; without a stated frame rate, use that of similar examples."""
    try:
        motion = read_motion(path)
        fps = options.fps or likely_fps(motion.header_fps, known)
        drop = options.drop_frames
        if drop is None:
            drop = find_recording_start(body_tracks(motion, fps=fps)).drop_frames
        if motion.frame_count - drop < MIN_FRAMES:
            raise PersonError(f"{path}: {max(motion.frame_count - drop, 0)} frames; {MIN_FRAMES} at least expected")
        return LeaderMotion(retarget_side(motion, Side(file=path.name, fps=fps, drop_frames=drop)), drop)
    except (MotionFileError, ValueError) as error:
        raise PersonError(str(error)) from None


def likely_fps(header: float, known: PartnerExamples) -> float:
    """Return the true frame rate of a file with rate `header` in its header.

    If all examples with that header have the same corrected rate, use it: files of one source have the same error.
    """
    like = {
        one.fps for one in (*known.leaders, *known.followers)
        if one is not None and abs(one.header_fps / header - 1.0) < 1e-3
    }  # fmt: skip
    return like.pop() if len(like) == 1 else header


def _search(options: PartnerOptions, led: LeaderMotion, known: PartnerExamples, walks: bool) -> SearchSettings:
    default = replace(WALK_SEARCH, max_path_distance=MAX_DISTANCE) if walks else SearchSettings()
    search = replace(
        default,
        rate=default.rate if options.rate is None else options.rate,
        stretch=default.stretch if options.stretch is None else options.stretch,
        k=default.k if options.k is None else options.k,
        beam=default.beam if options.beam is None else options.beam,
    )
    smoothing = cast(Literal["none", "linear", "eased"], options.smoothing)
    search = replace(search, smoothing=smoothing, hold_feet=options.hold_feet)
    beats = _beats(options, led, known)
    return search if beats is None else replace(search, beats=beats)


def _beats(options: PartnerOptions, led: LeaderMotion, known: PartnerExamples) -> npt.NDArray[np.float64] | None:
    """Return the leader's beats [s]: as given, else detected in their feet if clear, else guessed if needed."""
    clip = led.recorded.clip
    last = (clip.sample_count - 1.0) / clip.sample_rate
    if options.bpm is not None and options.first_beat is not None:
        return beat_samples(60.0 / options.bpm, options.first_beat, 1.0, last)
    if options.path is not None:
        return None
    if known.pairs_file.unit_beats == BEATS_OF_UNIT and all(len(one.beats) for one in known.units.examples):
        two_beats = float(np.median(known.units.seconds))
        followed = find_two_beat_lines([clip], two_beats if options.bpm is None else 120.0 / options.bpm)
        if followed is not None and followed.strength >= RELIABLE_STRENGTH:
            return followed.beats(last)
    if not options.online:
        return None
    guess = estimate_tempo(clip)
    if guess is None:
        raise PersonError("the leader's beats cannot be guessed", "--bpm BPM --first-beat SECONDS")
    return beat_samples(60.0 / guess.reference.bpm, guess.reference.first_beat_s, 1.0, last)


def _resample_to_leader(clip: Clip, led: LeaderMotion) -> Clip:
    """Resample the follower to the leader's frames; dropped leading frames hold the first pose."""
    frames = np.maximum(np.arange(led.recorded.frames + led.dropped) - led.dropped, 0)
    root, rotation, contact = read_clip(clip, frames * clip.sample_rate / led.recorded.fps)
    return Clip(
        clip.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32),
        led.recorded.fps, np.ascontiguousarray(contact),
    )  # fmt: skip


def _say(values: dict[str, Any], options: PartnerOptions) -> None:
    spent = ", ".join(f"{key} {value:.2f} s" for key, value in values["seconds"].items())
    print(f"{options.out}: {len(values['units'])} units for {values['frames'] / values['fps']:.1f} s ({spent})")
    if "truth" in values:
        figures = values["truth"]
        print(
            f"against {options.truth}: joints {figures['joint_error_m']:.3f} m off "
            f"({figures['joint_error_aligned_m']:.3f} m aligned), distance {figures['hip_distance_error_m']:.3f} m off"
        )
