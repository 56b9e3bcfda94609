"""Check of a step folder for errors and doubtful values, with file, line and field (T003, T043, T161).

Written attributes of each cut step are compared with measured ones.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from live.base.errors import PersonError
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.graph.structure_rules import plain_pose
from live.library.beat_alignment import guess_warnings
from live.library.recording_file import Problem, RecordingEntry, RecordingError, read_step_files
from live.library.recordings import RecordingReader, cut_recording
from live.library.step_folder import StepsError, sketched_steps, unify_names
from live.library.textured_steps import read_textured, stale_textures
from live.motion.beats.tempo_estimation import SAME_TEMPO, SIMPLE_RATIOS, estimate_tempo
from live.motion.cleanup.calibration_poses import calibration_ends
from live.motion.cleanup.frame_rate_check import suspect_frame_rate
from live.motion.cleanup.glitch_detection import Glitch
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.clip import clip_part, read_clip
from live.motion.editing.facing import circular_mean, heading_of
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.formats.source_axes import BODY_HEIGHT_RANGE, UNITS
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.body_tracks import BodyTracks, body_tracks
from live.motion.skeleton import BODY_HEIGHT, SOLE_BELOW_ANKLE
from live.motion.step_clip import FEET, StepClip, measured_direction, measured_distance, travel

DISTANCE_SHARE = 0.25
DISTANCE_MIN_M = 0.1
"""A written distance is accepted if it is off by less than this share of it, or by less than this many metres."""
MAX_DIRECTION_ERROR = math.radians(60.0)
"""Largest angle between the measured and the written direction."""
LEAD_IN_BEATS = 0.75
"""Beats that a transition needs before a step."""
MIN_CONTACT_SHARE = 0.1
"""Least share of a step with a foot on the floor."""
MAX_FACING_OFFSET = math.radians(120.0)
"""A step with its average heading farther than this from that at its first beat shows the back (T122)."""
MIN_FLIGHT = 0.08
"""A step that begins or ends with both soles higher than this [m] is in the air there."""
MAX_DELAY = 0.2
"""A T-pose that begins later than this [s] is not at the beginning."""
MAX_OFFSET_FROM_FEET = 0.11
"""A body leans whose hips are farther beside the feet than this [m] half of the time: dancers have 0.08 and less."""
_BEARING = {"forward": 0.0, "left": math.pi / 2, "back": math.pi, "right": -math.pi / 2}


def step_warnings(entry: RecordingEntry, step: StepClip) -> list[tuple[str, str]]:
    """Return field and message for each doubt about one step of a recording."""
    doubts = []
    recording, measured = entry.recording, measured_distance(step)
    if recording.direction is not None and not _direction_matches(step, recording.direction):
        doubts.append(
            ("direction", f"{recording.direction!r}, but it travels {measured_direction(step)}, {measured:.2f} m")
        )
    if recording.distance_m is not None:
        off = abs(recording.distance_m - measured)
        if off > max(DISTANCE_MIN_M, DISTANCE_SHARE * recording.distance_m):
            doubts.append(("distance_m", f"{recording.distance_m:g}, but {measured:.2f} m are measured"))
    if recording.weight_transfer and recording.leading_foot is None:
        words = 'true, but leading_foot is not given, so no other side is known; write leading_foot = "left" or "right"'
        doubts.append(("weight_transfer", words))
    first, last = int(step.first), math.ceil(step.first + step.measures * step.samples_per_measure)
    stands = step.clip.contact[first : last + 1].any(axis=1).mean()
    if stands < MIN_CONTACT_SHARE:
        often = (
            "no foot touches the floor in this step"
            if stands == 0
            else (f"a foot is on the floor in {100 * stands:.0f} % of this step only")
        )
        doubts.append(("file", f"{often}; check the floor, unit_m and up"))
    for field, at, words in (
        ("start_measure", step.first, "begins in the air, {:.2f} m over the floor, and a step before it ends on it"),
        ("measures", step.first + step.measures * step.samples_per_measure,
         "ends in the air, {:.2f} m over the floor, and a step after it begins on it; end it after the landing"),
    ):  # fmt: skip
        height = _flight_height(step, at)
        if height > MIN_FLIGHT:
            doubts.append((field, f"it {words.format(height)}"))
    away = abs(circular_mean(heading_of(step.clip.rotation[first : last + 1, 0])))
    if away > MAX_FACING_OFFSET:
        words = (
            f"it faces the audience at the first beat, and on average {math.degrees(away):.0f} degrees away from it: "
            'the back is to the audience; begin the step a measure later, or write face = "average" under [motion] '
            "in the patch"
        )
        doubts.append(("start_measure", words))
    held = calibration_ends(clip_part(step.clip, first, last + 1), within=MAX_DELAY)
    for field, place, samples in zip(("start_measure", "measures"), ("begins", "ends"), held, strict=True):
        if samples:
            seconds = samples / step.clip.sample_rate
            words = f"it {place} with {seconds:.1f} s of standing with the arms stretched out, as for a calibration"
            doubts.append((field, f"{words}; leave those measures out"))
    beat = 60.0 / recording.bpm
    begins = recording.first_beat_s + (recording.start_measure - 1) * recording.beats_per_measure * beat
    if begins < LEAD_IN_BEATS * beat:
        words = f"the recording begins {begins:.2f} s before the step: its first pose is held for the lead-in (T039)"
        doubts.append(("first_beat_s", words))
    return doubts


def _flight_height(step: StepClip, sample: float) -> float:
    """Height [m] of the lower sole over the floor at a sample at which no foot stands; 0 if one does."""
    root, rotation, contact = read_clip(step.clip, np.array([sample]))
    if contact.any():
        return 0.0
    position = forward_kinematics(root, rotation)[0][0, :, 1]
    return float(min(min(position[ankle] - SOLE_BELOW_ANKLE, position[toes] - TOES_OVER_SOLE) for ankle, toes in FEET))


def _direction_matches(step: StepClip, direction: str) -> bool:
    """Whether the travel is roughly in the written direction, at any distance."""
    word = direction.split()[-1]
    if word not in _BEARING:
        return measured_direction(step) == "in place"
    x, z = travel(step)
    if measured_direction(step) == "in place":
        return False
    off = math.remainder(math.atan2(x, z) - _BEARING[word], 2 * math.pi)
    return abs(off) <= MAX_DIRECTION_ERROR


MIN_TEMPO_CONFIDENCE: Final = 0.35
"""Least confidence of a tempo guessed from the feet to question the written one."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A problem: wrong (the step cannot be danced) or doubtful (it can, but should be reviewed)."""

    kind: Literal["wrong", "doubtful"]
    problem: Problem


@dataclass(frozen=True, slots=True, eq=False)
class FolderCheck:
    """A folder's usable steps, and its problems."""

    steps: list[StepClip]
    entries: list[RecordingEntry]
    findings: list[Finding]


def check_folder(directory: Path) -> FolderCheck:
    """Read and cut every step of a folder; RecordingError only if the folder cannot be read."""
    files = read_step_files(directory)
    findings = [Finding("wrong", problem) for problem in files.problems]
    steps: list[StepClip] = []
    for file, text in files.sketches.items():
        try:
            steps += sketched_steps({file: text})
        except StepsError as error:
            findings.append(Finding("wrong", _sketch_problem(Path(file), str(error))))
    textured, found = _textured_steps(files.sketches)
    steps += textured
    findings += found
    entries: list[RecordingEntry] = []
    for toml, group in files.recordings.items():
        reader, guessed = RecordingReader(), set[Path]()
        for entry in group:
            try:
                own = cut_recording(entry, reader.clip(entry))
            except RecordingError as error:
                findings += [Finding("wrong", problem) for problem in error.problems]
                continue
            steps += own
            entries.append(entry)
            doubts = step_warnings(entry, own[0]) + guess_warnings(entry, files.texts[toml])
            doubts += _glitches_inside(entry, reader, _measures(own))
            if entry.path not in guessed:
                guessed.add(entry.path)
                doubts += _tempo_warnings(entry, reader) + reading_warnings(entry, reader)
            findings += [Finding("doubtful", entry.problem(field, words)) for field, words in doubts]
    return FolderCheck(unify_names(steps), entries, findings)


def _textured_steps(sketches: Mapping[str, str]) -> tuple[list[StepClip], list[Finding]]:
    """The textured versions of sketches, and findings on invalid or outdated ones."""
    words = "the sketch was changed since: make it again with live steps enrich, or remove it"
    try:
        old = [Finding("doubtful", Problem(path, None, "", words)) for path in stale_textures(sketches)]
        return read_textured(sketches), old
    except PersonError as error:
        path, _, rest = str(error).partition(": ")
        return [], [Finding("wrong", Problem(Path(path), None, "", rest))]


def _sketch_problem(file: Path, words: str) -> Problem:
    line, _, rest = words.removeprefix(f"{file}:").partition(": ")
    return Problem(file, int(line), "", rest) if line.isdigit() else Problem(file, None, "", words)


def _measures(own: list[StepClip]) -> int:
    """Measures of a step or of a stream, without mirror images."""
    return sum(clip.measures for clip in own if not clip.mirrored)


def _glitches_inside(entry: RecordingEntry, reader: RecordingReader, measures: int) -> list[tuple[str, str]]:
    """Tracking faults in the step or its lead-in (T161)."""
    recording = entry.recording
    motion = reader.motion(entry)
    rate = recording.fps or motion.header_fps
    measure = recording.beats_per_measure * 60.0 / recording.bpm
    begin = recording.first_beat_s + (recording.start_measure - 2) * measure
    end = begin + (measures + 1) * measure
    found = []
    for glitch in reader.glitches(entry):
        first, last = ((frame - recording.drop_frames) / rate for frame in (glitch.first_frame, glitch.last_frame))
        if last >= begin and first <= end:
            found.append(("file", _glitch_text(glitch, first, recording.repair)))
    return found


def _glitch_text(glitch: Glitch, seconds: float, repaired: bool) -> str:
    frames = f"frame {glitch.first_frame}"
    if glitch.last_frame > glitch.first_frame:
        frames = f"frames {glitch.first_frame} to {glitch.last_frame}"
    remedy = "it could not be mended" if repaired else "write repair = true"
    return (
        f"{frames} ({max(seconds, 0.0):.2f} s), inside the step or its lead-in: {glitch.kind} "
        f"({', '.join(glitch.joints[:3])}, off by {100 * glitch.size_m:.0f} cm); {remedy}, or choose other measures"
    )


def _tempo_warnings(entry: RecordingEntry, reader: RecordingReader) -> list[tuple[str, str]]:
    guess = estimate_tempo(reader.clip(entry), entry.recording.beats_per_measure)
    if guess is None or guess.reference.confidence < MIN_TEMPO_CONFIDENCE:
        return []
    bpm, written = guess.reference.bpm, entry.recording.bpm
    heard = [bpm * ratio for ratio in SIMPLE_RATIOS] + list(guess.other_bpm)
    if min(abs(math.log(written / one)) for one in heard) <= math.log(1 + SAME_TEMPO):
        return []
    return [("bpm", f"{written:g}, but the feet give {bpm:.1f} (confidence {guess.reference.confidence:.2f})")]


def reading_warnings(entry: RecordingEntry, reader: RecordingReader) -> list[tuple[str, str]]:
    """Return field and message for doubts about how a file was read: its frame rate and its unit of length.

    `fps` and `unit_m` settle them.
    """
    recording = entry.recording
    motion = reader.motion(entry)
    tracks = body_tracks(motion, fps=recording.fps, up=recording.up, unit_m=recording.unit_m)
    doubts = []
    if recording.fps is None:
        start = max(recording.drop_frames, find_recording_start(tracks).drop_frames)
        suspicion = suspect_frame_rate(tracks, start)
        if suspicion is not None:
            doubts.append(("fps", str(suspicion)))
    beside = hips_beside_feet(tracks)
    if beside > MAX_OFFSET_FROM_FEET:
        words = f"half of the time the hips are more than {beside:.2f} m beside the feet: the body leans as if it fell"
        doubts.append(("file", f"{words}; the suit's hips have drifted, so record it again or correct it"))
    if recording.unit_m is None and tracks.unit_m not in (*UNITS, motion.unit_m):
        low, high = BODY_HEIGHT_RANGE
        words = f"in no usual unit is the dancer {low} to {high} m tall; body and ways are scaled to {BODY_HEIGHT} m"
        doubts.append(("unit_m", words))
    return doubts


def hips_beside_feet(tracks: BodyTracks) -> float:
    """Return the median horizontal distance [m] of the hips from the line between the ankles."""
    hips, left, right = (
        points[:, (0, 2)]
        for points in (tracks.positions[:, tracks.column("hips") or 0], tracks.ankles[:, 0], tracks.ankles[:, 1])
    )
    way = right - left
    along = ((hips - left) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-9)
    off = hips - left - np.clip(along, 0.0, 1.0)[:, None] * way
    return float(np.median(np.hypot(*off.T)))


def check_connections(checked: Sequence[FolderCheck], folder: Path, threshold: float) -> list[Finding]:
    """Find steps without a transition to or from others within `threshold` [m], and unmatched pose names."""
    clips = [clip for one in checked for clip in one.steps]
    entries = [entry for one in checked for entry in one.entries]
    findings = _unmatched_poses(clips, entries)
    for beats in sorted({clip.beats_per_measure for clip in clips}):
        fitting = [clip for clip in clips if clip.beats_per_measure == beats]
        try:
            missing: tuple[str, ...] = build_graph(build_library(fitting), threshold=threshold).missing
        except ValueError as error:
            missing = (str(error),)
        for words in missing:
            name, _, why = words.partition(": ")
            entry = next((entry for entry in entries if entry.recording.name == name), None)
            problem = Problem(folder, None, "", words) if entry is None else entry.problem("name", f"{name}: {why}")
            findings.append(Finding("doubtful", problem))
    return findings


def _unmatched_poses(clips: list[StepClip], entries: list[RecordingEntry]) -> list[Finding]:
    """Pose names that occur only at beginnings or only at ends of steps: usually typing errors."""
    begins = {plain_pose(clip.begin_pose): clip.begin_pose for clip in clips if clip.begin_pose}
    ends = {plain_pose(clip.end_pose): clip.end_pose for clip in clips if clip.end_pose}
    findings = []
    for entry in entries:
        for field, others, words in (
            ("end_pose", begins, "no step begins in"),
            ("begin_pose", ends, "no step ends in"),
        ):
            pose = getattr(entry.recording, field)
            if pose is not None and plain_pose(pose) not in others:
                there = ", ".join(map(repr, sorted(others.values()))) or "none is named"
                problem = entry.problem(field, f"{words} {pose!r}; there are: {there}")
                findings.append(Finding("doubtful", problem))
    return findings
