"""Reader for partner examples: a TOML file of pairs of recordings of leader and follower, cut into units (H001).

Hand holds without annotation are found in the recordings.
"""

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.base.toml import KeyPath, error_line, line_of, parse_toml, toml_line_numbers
from live.library.disk_cache import read_regular_file
from live.library.motion_file import read_motion
from live.library.recording_file import FileName, Word
from live.motion.beats.tempo_estimation import RELIABLE_STRENGTH, estimate_tempo, find_two_beat_lines
from live.motion.cleanup.glitch_detection import find_glitches
from live.motion.cleanup.glitch_repair import repair
from live.motion.clip import Clip
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion
from live.motion.partner.evaluation import HoldCriterion, detect_holds
from live.motion.partner.point_clouds import ends_cloud, leader_cloud, path_cloud
from live.motion.partner.units import BEATS_OF_UNIT, Example, Hold, Units, beat_cuts, beat_samples, cut_units
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.retarget import retarget

IGNORED_KEYS: Final = (
    "start_measure", "measures", "beats_per_measure", "leading_foot", "begin_pose", "end_pose", "weight_transfer",
    "direction", "distance_m", "tags", "author", "style", "unstructured", "mirror",
)  # fmt: skip
"""Keys of step descriptions that are allowed here but ignored."""
Time = Annotated[float, Field(ge=0, le=36_000)]
Hand = Literal["left", "right", "leftHand", "rightHand"]


class Beats(BaseModel):
    """Beats of a recording, counted from the first frame that is kept."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    beat_s: Annotated[float, Field(ge=0.15, le=3)] | None = None
    """Seconds of a beat, instead of `bpm`."""
    first_beat_s: Time | None = None
    """Time of the first beat of any unit [s]."""

    @property
    def period(self) -> float | None:
        """Seconds of a beat, if given."""
        return self.beat_s if self.beat_s is not None else None if self.bpm is None else 60.0 / self.bpm


class Side(Beats):
    """One of the two recordings."""

    file: FileName
    name: Word | None = None
    skeleton: FileName | None = None
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """Frame rate, if the one in the file header is wrong."""
    unit_m: Annotated[float, Field(gt=0, le=10)] | None = None
    up: Literal["Y", "Z"] | None = None
    drop_frames: Annotated[int, Field(ge=0, le=10_000_000)] = 0
    repair: bool = False
    """Whether tracking faults are repaired where that is safe (T161)."""

    @model_validator(mode="before")
    @classmethod
    def _drop_ignored_keys(cls, values: Any) -> Any:
        if isinstance(values, dict):
            return {key: value for key, value in values.items() if key not in IGNORED_KEYS}
        return values


class Pair(Beats):
    """Two synchronous recordings of one take; without `leader` a walk, which is led by its path."""

    leader: Side | None = None
    follower: Side
    name: Word | None = None
    style: Word | None = None
    """How the follower dances; pairs without it are of every style."""
    cuts_s: list[Time] | None = None
    """Times at which units begin and end [s], given by hand instead of beats."""
    holds: list[tuple[Hand, Hand, Time, Time]] = []
    """Hand holds: the leader's hand, the follower's hand, begin, end [s]."""


class PairsFile(BaseModel):
    """A file of pairs, the database of examples."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    pair: Annotated[list[Pair], Field(min_length=1, max_length=1000)]
    unit_beats: Annotated[int, Field(ge=1, le=16)] = BEATS_OF_UNIT
    """Beats of a unit."""
    cut: Literal["beats", "steps"] | None = None
    """Where units are cut: at every `unit_beats`th beat, or at each foot landing (walks)."""


MAX_BYTES: Final = 1_000_000
SHOWN_PROBLEMS: Final = 8
MIN_UNIT_SECONDS: Final = 0.15
"""Least length of a unit [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedSide:
    """One side of a pair on the engine's skeleton, at its recorded position."""

    clip: Clip
    frames: int
    """Number of frames kept."""
    fps: float
    header_fps: float


@dataclass(frozen=True, slots=True, eq=False)
class PartnerExamples:
    """The contents of a file of pairs."""

    file: Path
    pairs_file: PairsFile
    units: Units
    leaders: tuple[RecordedSide | None, ...]
    followers: tuple[RecordedSide, ...]


def read_pairs(toml: Path, *, style: str | None = None, text: str | None = None) -> PartnerExamples:
    """Read all pairs of a file, or those of a style (H025); PersonError with file, line and field for anything invalid.

    Pairs without a style are of every style. `text`: what the file held, if not what it holds now.
    """
    wanted, fail = _parse_pairs(toml, pairs_text(toml) if text is None else text)
    examples, leaders, followers = [], [], []
    for n, pair in _pairs_of_style(wanted, style, fail):
        where: KeyPath = ("pair", n)
        follower = _load_side(pair.follower, toml, partial(fail, (*where, "follower")))
        leader = None
        if pair.leader is not None:
            leader = _load_side(pair.leader, toml, partial(fail, (*where, "leader")))
            _check_synchronous(leader, follower, partial(fail, where))
        example = _build_example(wanted, pair, leader, follower, partial(fail, where))
        examples.append(example)
        leaders.append(leader)
        followers.append(follower)
    if any(one is None for one in leaders) and any(one is not None for one in leaders):
        raise fail(("pair",), "some pairs have a leader and some have none; a database is of one kind")
    units = cut_units(examples)
    if units.count < 2:
        raise fail(("pair",), f"{units.count} unit in all of it; at least two are needed to choose from")
    if style is not None:
        wanted = wanted.model_copy(update={"pair": [pair for _, pair in _pairs_of_style(wanted, style, fail)]})
    return PartnerExamples(toml, wanted, units, tuple(leaders), tuple(followers))


def _pairs_of_style(
    wanted: PairsFile, style: str | None, fail: Callable[[KeyPath, str], PersonError]
) -> list[tuple[int, Pair]]:
    """Return the pairs of a style with their numbers in the file; PersonError if no pair has it."""
    if style is None:
        return list(enumerate(wanted.pair))
    name = style.strip().casefold()
    known = {pair.style.strip().casefold() for pair in wanted.pair if pair.style is not None}
    if name not in known:
        told = f"there are: {', '.join(sorted(known))}" if known else "no pair has a style"
        raise fail(("pair",), f"no pair has the style {style[:64]!r}; {told}")
    return [
        (n, pair) for n, pair in enumerate(wanted.pair) if pair.style is None or pair.style.strip().casefold() == name
    ]


def pairs_text(toml: Path) -> str:
    """Return the text of a file of pairs; PersonError if it cannot be read, or is too long."""
    try:
        held = read_regular_file(toml, MAX_BYTES)
        if len(held) > MAX_BYTES:
            raise PersonError(f"{toml}: more than {MAX_BYTES} bytes")
        return held.decode("utf-8-sig")
    except OSError as error:
        raise PersonError(f"cannot read the pairs {toml}: {error.strerror}", "--examples PAIRS.toml") from None
    except UnicodeDecodeError as error:
        raise PersonError(f"{toml}: not a text in UTF-8 (byte {error.start})") from None


def _parse_pairs(toml: Path, text: str) -> tuple[PairsFile, Callable[[KeyPath, str], PersonError]]:
    try:
        data = parse_toml(text)
    except tomllib.TOMLDecodeError as error:
        raise PersonError(f"{toml}, line {error_line(str(error), text)}: not valid TOML: {error}") from None
    except RecursionError:
        raise PersonError(f"{toml}: brackets in brackets too deep") from None
    lines = toml_line_numbers(text)

    def fail(where: KeyPath, words: str) -> PersonError:
        name = ".".join(str(part + 1) if isinstance(part, int) else part for part in where)
        return PersonError(f"{toml}, line {line_of(lines, where)}: {name}: {words}")

    try:
        return PairsFile.model_validate(data), fail
    except ValidationError as error:
        told = [fail(tuple(one["loc"]), _problem_text(one)).message for one in error.errors(include_url=False)]
        raise PersonError("; ".join(told[:SHOWN_PROBLEMS]), "`live docs partners` describes files of pairs") from None


def _problem_text(problem: Any) -> str:
    if problem["type"] == "missing":
        return "missing; it must be given"
    if problem["type"] == "extra_forbidden":
        return "unknown key"
    return f"{problem['msg'][:1].lower()}{problem['msg'][1:]}, found {str(problem['input'])[:60]!r}"


def read_side(path: Path, side: Side) -> RecordedSide:
    """Read one recording at its recorded position; MotionFileError or ValueError if it cannot be used."""
    motion = read_motion(path, skeleton=None if side.skeleton is None else path.parent / side.skeleton, up=side.up)
    return retarget_side(motion, side)


def retarget_side(motion: SourceMotion, side: Side) -> RecordedSide:
    """Return the same for a motion that was already read."""
    fps = side.fps or motion.header_fps
    if side.repair:
        tracks = body_tracks(motion, fps=fps, up=side.up, unit_m=side.unit_m)
        motion, _ = repair(motion, find_glitches(tracks, motion.parents, side.drop_frames), fps=fps)
    clip = retarget(
        motion, name=Path(side.file).stem, fps=fps, unit_m=side.unit_m, up=side.up,
        drop_frames=side.drop_frames, centred=False,
    )  # fmt: skip
    return RecordedSide(clip, motion.frame_count - side.drop_frames, fps, motion.header_fps)


def _load_side(side: Side, toml: Path, fail: Callable[[str], PersonError]) -> RecordedSide:
    try:
        return read_side(toml.parent / side.file, side)
    except (MotionFileError, ValueError) as error:
        raise fail(str(error)) from None


def _check_synchronous(leader: RecordedSide, follower: RecordedSide, fail: Callable[[str], PersonError]) -> None:
    if abs(leader.fps / follower.fps - 1.0) > 1e-3:
        raise fail(
            f"the leader has {leader.fps:g} frames a second and the follower {follower.fps:g}; "
            "both of a pair have one rate: give the true one with fps"
        )
    if leader.frames != follower.frames:
        raise fail(
            f"the leader has {leader.frames} frames and the follower {follower.frames}; they must be "
            "synchronous: the same frames of one take, less drop_frames, expected"
        )


def _build_example(
    wanted: PairsFile,
    pair: Pair,
    leader: RecordedSide | None,
    follower: RecordedSide,
    fail: Callable[[str], PersonError],
) -> Example:
    clip = follower.clip
    last, rate = clip.sample_count - 1.0, clip.sample_rate
    cuts, beats = _unit_cuts(wanted, pair, leader, follower, fail)
    if len(cuts) < 2:
        raise fail(f"{last / rate:.2f} s are too short for one unit")
    if (np.diff(cuts) < MIN_UNIT_SECONDS * rate).any():
        raise fail(f"a unit of {np.diff(cuts).min() / rate:.2f} s; {MIN_UNIT_SECONDS} s at least expected")
    for _, _, begin, end in pair.holds:
        if not begin < end <= last / rate + 1e-6:
            raise fail(f"a hold from {begin:g} to {end:g} s; within 0 to {last / rate:.2f} s expected")
    holds = tuple(
        Hold(int(one.startswith("right")), int(other.startswith("right")), begin * rate, end * rate)
        for one, other, begin, end in pair.holds
    )
    control = path_cloud(clip) if leader is None else ends_cloud(leader.clip)
    name = pair.name or pair.follower.name or Path(pair.follower.file).stem
    body = None if leader is None else leader_cloud(leader.clip)
    return Example(name, control, ends_cloud(clip), clip, cuts, beats, holds, body)


def _unit_cuts(
    wanted: PairsFile,
    pair: Pair,
    leader: RecordedSide | None,
    follower: RecordedSide,
    fail: Callable[[str], PersonError],
) -> tuple[Float64, Float64]:
    """Limits of units and positions of beats [samples]."""
    clip = follower.clip
    rate, last = clip.sample_rate, clip.sample_count - 1.0
    sides = [one for one in (pair, pair.leader, pair.follower) if one is not None]
    period = next((one.period for one in sides if one.period is not None), None)
    first = next((one.first_beat_s for one in sides if one.first_beat_s is not None), None)
    if pair.cuts_s is None and (wanted.cut or ("steps" if leader is None else "beats")) == "steps":
        landed = np.flatnonzero((np.diff(clip.contact.astype(np.int8), axis=0) > 0).any(axis=1)) + 1.0
        keep = np.concatenate(([True], np.diff(landed) >= 2.0 * MIN_UNIT_SECONDS * rate))
        return np.asarray(landed[keep], np.float64), np.zeros(0)
    if first is None and pair.cuts_s is None and leader is not None and wanted.unit_beats == BEATS_OF_UNIT:
        followed = find_two_beat_lines([leader.clip, clip], None if period is None else 2.0 * period)
        if followed is not None and followed.strength >= RELIABLE_STRENGTH:
            return followed.lines * rate, followed.beats(last / rate) * rate
    if (period is None or first is None) and pair.cuts_s is None:
        guess = estimate_tempo(clip, bpm=None if period is None else 60.0 / period)
        if guess is None:
            raise fail("too short or too still to guess its beats: give bpm and first_beat_s")
        period = 60.0 / guess.reference.bpm
        first = guess.reference.first_beat_s if first is None else first
    beats = np.zeros(0) if period is None or first is None else beat_samples(period, first, rate, last)
    if pair.cuts_s is not None:
        cuts = np.unique(np.array(pair.cuts_s, np.float64)) * rate
        return np.asarray(cuts[cuts <= last], np.float64), beats
    assert period is not None  # given or guessed
    assert first is not None
    before = int(np.floor(first / period + 1e-9)) % wanted.unit_beats
    return beat_cuts(beats[before:], last, wanted.unit_beats), beats


def add_found_holds(known: PartnerExamples, near: HoldCriterion) -> Units:
    """Return the units of `known`, with holds found in the recordings for pairs without `holds`."""
    return replace(known.units, examples=tuple(_with_found_holds(known, n, near) for n in range(len(known.leaders))))


def _with_found_holds(known: PartnerExamples, n: int, near: HoldCriterion) -> Example:
    example, leader = known.units.examples[n], known.leaders[n]
    if leader is None or "holds" in known.pairs_file.pair[n].model_fields_set:
        return example
    return replace(example, holds=detect_holds(leader.clip, example.follower, near))
