"""Measure map of a music file for `live music map`: proposed, corrected by fixes, read and written in other forms."""

import json
import statistics
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.base.system.process_control import lower_priority_of, own_session
from live.clock.beat_estimate import Samples
from live.clock.measure_map import MeasureLine, MeasureMap, Phrase
from live.clock.tracking.beat_network import ActivationStream, BeatNetwork
from live.clock.tracking.offline_beats import HIGH_BPM, LOW_BPM, Activations, Beats, find_beats
from live.control.audio.analysis import WEIGHTS, WEIGHTS_BACKWARDS, beat_weights
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.library.music_map_file import read_map
from live.show.patch.patch_search_path import find_resource

BLOCK: Final = 4096
PROPOSAL_NICE: Final = 15
PROPOSAL_TIMEOUT: Final = 600.0
"""Longest time for the measures of a piece [s]."""
OCTAVE: Final = (0.8, 1.25)
"""Range of the tempo around half or double the former one."""
MAX_MUSIC_S: Final = 3600.0
LEAST_SHARE: Final = 1e-6
"""Least probability whose logarithm is taken."""
BACKWARDS: Final = 0.65
"""Weight of what is heard backwards, where measures are right more often (40 made pieces that were not learned)."""
Do = Literal["move", "insert", "delete", "half", "double", "metre", "ramp", "step", "phrase"]


class Fix(BaseModel):
    """A correction by a person."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    do: Do
    """`move` a line (all lines follow: they are found again), `insert` or `delete` one, `half` or `double` the tempo,
    `metre` from a line on, the tempo of a measure as `ramp` or `step`, a `phrase` that begins with a measure."""
    line: Annotated[int, Field(ge=1)] | None = None
    """The measure line, by its number in the map after the corrections before."""
    time_s: Annotated[float, Field(ge=0, le=36000, allow_inf_nan=False)] | None = None
    """Where a line belongs [s]."""
    beats: Annotated[int, Field(ge=1, le=16)] | None = None
    """Beats of a measure."""
    name: Annotated[str, Field(max_length=64)] = ""
    """Name of a phrase."""


NEEDS: Final[dict[str, tuple[str, ...]]] = {
    "move": ("time_s",), "insert": ("time_s",), "delete": ("line",), "metre": ("beats",), "ramp": ("line",),
    "step": ("line",), "phrase": ("line",),
}  # fmt: skip


def read_fixes(path: Path) -> list[Fix]:
    """Return the corrections in a JSON file; PersonError that names the faulty one."""
    try:
        found = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise PersonError(f"cannot read the corrections {path}: {error}") from None
    if not isinstance(found, list):
        raise PersonError(f"{path}: a list of corrections expected", '[{"do": "move", "line": 1, "time_s": 2.5}]')
    fixes = []
    for number, values in enumerate(found, start=1):
        try:
            fix = Fix.model_validate(values)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = ".".join(map(str, first["loc"]))
            raise PersonError(f"{path}: correction {number}: {where}: {first['msg']}") from None
        missing = [key for key in NEEDS.get(fix.do, ()) if getattr(fix, key) is None]
        if missing:
            raise PersonError(f"{path}: correction {number}: {fix.do} needs {' and '.join(missing)}")
        fixes.append(fix)
    return fixes


def hear(music: Music) -> Activations:
    """Return the networks' probabilities for a whole piece, heard forwards and backwards; PersonError if it is too
    long.

    Forwards, the first measures are heard without knowing what comes; backwards, the last ones (Schuster and Paliwal,
    Bidirectional recurrent neural networks, 1997). Where both know the music, what they say together is surer.
    """
    if music.samples.shape[0] > MAX_MUSIC_S * music.sample_rate:
        raise PersonError(f"the music is longer than {MAX_MUSIC_S / 60:g} minutes", "cut it into pieces")
    mono = music.samples.mean(axis=1, dtype=np.float32)
    time, *forwards = _probabilities(mono, music.sample_rate, WEIGHTS)
    before_end, *backwards = _probabilities(mono[::-1].copy(), music.sample_rate, WEIGHTS_BACKWARDS)
    seconds = mono.size / music.sample_rate
    kept = (time >= 0.0) & (time <= seconds)
    if not kept.any():
        return Activations(np.zeros(0), np.zeros(0), np.zeros(0))
    time = time[kept]
    mirrored = [np.interp(seconds - time, before_end, column) for column in backwards]
    beat, downbeat = _mean_probabilities([column[kept] for column in forwards], mirrored)
    return Activations(time, beat, downbeat)


def _probabilities(mono: Samples, sample_rate: float, weights: tuple[str, ...]) -> list[Float64]:
    """Return times [s] and probabilities of a beat and of a downbeat of all frames, (T,) each."""
    stream = ActivationStream(sample_rate, BeatNetwork(*beat_weights(weights)))
    rest = np.zeros(int(sample_rate), np.float32)  # the network is some frames late
    rows: list[list[Float64]] = []
    for block in (*(mono[at : at + BLOCK] for at in range(0, mono.size, BLOCK)), rest):
        count = stream.feed(block)
        rows.append([column[:count].astype(np.float64) for column in (stream.position, stream.beat, stream.downbeat)])
    return [np.concatenate([row[k] for row in rows]) for k in range(3)]


def _mean_probabilities(forwards: Sequence[Float64], backwards: Sequence[Float64]) -> tuple[Float64, Float64]:
    """Return the probabilities of a beat and a downbeat whose log-odds are the weighted mean of two
    (beat, downbeat) pairs, (T,) each."""
    total = np.zeros((3, forwards[0].size))
    for weight, (beat, downbeat) in ((1.0 - BACKWARDS, forwards), (BACKWARDS, backwards)):
        shares = np.stack([1.0 - beat, beat - downbeat, downbeat])
        total += weight * np.log(np.maximum(shares, LEAST_SHARE))
    shares = np.exp(total - total.max(axis=0))
    shares /= shares.sum(axis=0)
    return shares[1] + shares[2], shares[2]


@dataclass
class MapProposal:
    """The map that the tracker proposes, with what a person said about it."""

    activations: Activations
    bpm_range: tuple[float, float] = (LOW_BPM, HIGH_BPM)
    downbeats: list[float] = field(default_factory=list)
    metres: list[tuple[float, int]] = field(default_factory=list)
    local: list[Fix] = field(default_factory=list)
    """Corrections of single lines, phrases and tempo runs, in their order."""

    def beats(self) -> Beats:
        """Return all beats."""
        return find_beats(self.activations, bpm_range=self.bpm_range, downbeats=self.downbeats, metres=self.metres)

    def map(self) -> MeasureMap:
        """Return the map; PersonError if no beat was found, or a correction fits none."""
        found = map_of_beats(self.beats())
        for fix in self.local:
            found = _with_local(found, fix)
        return found

    def correct(self, fix: Fix) -> None:
        """Take in a correction; PersonError if its line does not exist."""
        if fix.do in ("insert", "delete", "ramp", "step", "phrase"):
            self.local.append(fix)
            self.map()  # names a line that does not exist
            return
        now = self.map()
        match fix.do:
            case "half" | "double":
                bpm = now.bpm * (0.5 if fix.do == "half" else 2.0)
                self.bpm_range = max(bpm * OCTAVE[0], LOW_BPM * 0.5), min(bpm * OCTAVE[1], HIGH_BPM)
            case "move":
                assert fix.time_s is not None
                self.downbeats.append(fix.time_s)
            case "metre":
                assert fix.beats is not None
                begin = 0.0 if fix.line is None else now.lines[_line_index(now, fix.line)].time_s
                self.metres.append((begin, fix.beats))
        try:
            self.beats()
        except ValueError as error:
            raise PersonError(f"{fix.do}: {error}") from None


def _line_index(found: MeasureMap, number: int) -> int:
    if not 1 <= number <= len(found.lines):
        raise PersonError(f"there is no line {number}", f"there are {len(found.lines)}")
    return number - 1


def _with_local(found: MeasureMap, fix: Fix) -> MeasureMap:
    try:
        match fix.do:
            case "insert":
                assert fix.time_s is not None
                return found.with_line(fix.time_s)
            case "delete":
                assert fix.line is not None
                return found.without_line(_line_index(found, fix.line))
            case "ramp" | "step":
                assert fix.line is not None
                return found.with_run(_line_index(found, fix.line), fix.do)
    except ValueError as error:
        raise PersonError(f"{fix.do}: {error}") from None
    assert fix.line is not None
    index = _line_index(found, fix.line)
    kept = [phrase for phrase in found.phrases if phrase.measure != found.lines[index].measure]
    return MeasureMap(found.lines, [*kept, Phrase(found.lines[index].measure, fix.name)])


def map_of_beats(beats: Beats) -> MeasureMap:
    """Return the map whose lines are the downbeats; PersonError if there is none."""
    starts = np.flatnonzero(beats.number == 0).tolist()
    if not starts:
        raise PersonError("no measure was found in this music", "give its first line: --fix with an insert")
    lines = []
    for number, start in enumerate(starts, start=1):
        end = starts[number] if number < len(starts) else start + int(beats.metre[start])
        lines.append(MeasureLine(round(float(beats.time[start]), 4), number, end - start))
    return MeasureMap(lines)


def read_measures(music: Path, fixes: Sequence[Fix] = (), lines: Path | None = None) -> MeasureMap:
    """Return the measures of a music file: those in `lines`, or as the tracker proposes them with a person's `fixes`.

    PersonError for a faulty file, and for a correction that fits nothing.
    """
    try:
        sound = read_music(music)
    except MusicFileError as error:
        raise PersonError(str(error)) from None
    if lines is not None:
        if fixes:
            raise PersonError("corrections are for a proposal", "leave out --fix, or the lines")
        return read_map(lines)
    proposal = MapProposal(hear(sound))
    for number, each in enumerate(fixes, start=1):
        try:
            proposal.correct(each)
        except PersonError as error:
            raise PersonError(f"correction {number}: {error.message}", error.remedy) from None
    return proposal.map()


def measures_of_resource(patch: Path, file: str, lines: str = "") -> MeasureMap:
    """Return the measures of a music file that the patch in `patch` can name: those in the file `lines`, or as the
    tracker proposes them in a process of its own, at low priority.

    PersonError for a file that is missing or faulty.
    """
    music, known = find_resource(file, patch), find_resource(lines, patch) if lines else None
    missing = file if music is None else lines if lines and known is None else None
    if music is None or missing is not None:
        raise PersonError(f"there is no file {missing!r}", "put it next to the patch")
    if known is not None:
        return read_map(known)
    command = [sys.executable, "-m", "live", "music", "map", str(music), "--json"]
    process = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **own_session()
    )
    lower_priority_of(process.pid, PROPOSAL_NICE)
    try:
        told, errors = process.communicate(timeout=PROPOSAL_TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        raise PersonError(f"the measures of {file!r} were not found within {PROPOSAL_TIMEOUT:g} s") from None
    if process.returncode:
        raise PersonError(" ".join(errors.decode(errors="replace").split())[-400:] or f"{file!r} cannot be heard")
    values = json.loads(told)
    rows = [MeasureLine(one["time_s"], one["measure"], one["beats"], one["tempo"]) for one in values["lines"]]
    return MeasureMap(rows, [Phrase(one["measure"], one["name"]) for one in values["phrases"]])


def map_values(found: MeasureMap, beats: Sequence[float] = ()) -> dict[str, Any]:
    """Return a map as values for JSON."""
    lines = [
        {"time_s": line.time_s, "measure": line.measure, "beats": line.beats, "tempo": line.tempo}
        for line in found.lines
    ]
    phrases = [{"measure": phrase.measure, "name": phrase.name} for phrase in found.phrases]
    gaps = [b.time_s - a.time_s for a, b in zip(found.lines, found.lines[1:], strict=False)]
    beat_times = [round(found.time_at(float(k)), 4) for k in range(round(found.line_beat(len(found.lines) - 1)) + 1)]
    return {
        "bpm": round(found.bpm, 3),
        "measure_s": round(statistics.median(gaps), 4) if gaps else None,
        "lines": lines,
        "phrases": phrases,
        "beats": list(beats) or beat_times,
    }
