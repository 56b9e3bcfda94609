"""Partners by example on real salsa: each take answered from the others (H022), beside simpler followers."""

import json
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from bench import texture_quality
from bench._partner_baselines import constant_offset, kernel_regression, nearest_frames, nearest_units
from live.cli.bench import Row
from live.library.partner_pairs import PartnerExamples, add_found_holds, read_pairs
from live.motion.beats.dance_rhythm import find_rhythm
from live.motion.beats.tempo_estimation import find_two_beat_lines
from live.motion.clip import Clip
from live.motion.partner.answer import PALM_OFFSET, palms
from live.motion.partner.evaluation import (
    FollowerErrors,
    HoldCriterion,
    facing_of,
    find_turns,
    follower_errors,
    hands_near,
    joint_positions,
    same_turns,
    slide_metrics,
    wrong_facing,
)
from live.motion.partner.partner_synthesis import SearchSettings, find_partner, shown_beats
from live.motion.partner.point_clouds import ends_cloud, leader_cloud
from live.motion.partner.units import Example, Hold, cut_units
from live.motion.partner_live.follower_filter import expected_follower
from live.motion.partner_live.live_partner import evaluate_live
from live.motion.quality.metrics import beat_offsets
from live.motion.skeleton import SKELETON

DROPPED = 6
"""Frames of a T-pose and the run-in from it."""
HOLDS = HoldCriterion(0.2, 0.3)
"""The pairs' hold criterion."""
QUICK = (0, 3, 6)
"""Takes of the quick form: all are learnt from, these are left out in turn."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """Leave one take out, and what the bench texture-quality measures; without the recordings all rows are without
    values."""
    textured = [replace(row, name=f"texture, {row.name}") for row in texture_quality.run(full, shared)]
    return [*_partners(full, shared), *textured]


def _partners(full: bool, shared: Path | None) -> list[Row]:
    takes = [] if shared is None else _takes(shared)
    if shared is None or not takes:
        return [Row("salsa, leave one take out", None, "m")]
    known, followed = _read(_pairs(shared, takes, known=True)), _read(_pairs(shared, takes, known=False))
    left_out = tuple(range(len(takes))) if full else QUICK
    spoiled = spoiled_rows(known, left_out) if full else []
    return [*rows_of(known, left_out), *followed_rows(followed, left_out), *spoiled]


def _read(pairs: str) -> PartnerExamples:
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(pairs)
        file.flush()
        known = read_pairs(Path(file.name))
        return replace(known, units=add_found_holds(known, HOLDS))


def _takes(shared: Path) -> list[dict[str, Any]]:
    beats = shared / "mocap" / "beats_estimated.json"
    if not beats.is_file():
        return []
    return [
        one for one in json.loads(beats.read_text())
        if len(one["files"]) == 2 and all((shared / "mocap" / file).is_file() for file in one["files"])
    ]  # fmt: skip


def _pairs(shared: Path, takes: list[dict[str, Any]], *, known: bool) -> str:
    """The pairs, their beats `known` (the estimates with the recordings), or to be found in how they move."""
    lines = []
    for take in takes:
        leader, follower = (json.dumps(str((shared / "mocap" / file).resolve())) for file in take["files"])
        common = f"fps = {take['true_fps']}, drop_frames = {DROPPED}"
        beats = f", beat_s = {take['beat_s']}, first_beat_s = {take['phase_of_4beats_s']}" if known else ""
        lines.append(f"[[pair]]\nleader = {{ file = {leader}, {common}, repair = true{beats} }}")
        lines.append(f"follower = {{ file = {follower}, {common} }}")
    return "\n".join(lines) + "\n"


class Tally:
    """Errors by follower, take by take."""

    def __init__(self) -> None:
        self.errors: dict[str, list[FollowerErrors]] = {}
        self.slides: dict[str, list[float]] = {}
        self.offsets: dict[str, list[float]] = {}
        self.wrong: dict[str, list[float]] = {}
        self.turns: dict[str, list[tuple[int, int, int]]] = {}
        self.near: dict[str, list[float]] = {}
        self.live: list[dict[str, Any]] = []
        self.apart: list[list[float]] = []

    def add(self, name: str, clip: Clip, contact: Any, take: "Take") -> None:
        """A follower of one take."""
        joints = joint_positions(clip)
        self.add_joints(name, joints, facing_of(clip), palms(clip), take)
        slid = slide_metrics(joints, contact, clip.sample_rate)["foot_slide_mean"]
        self.slides.setdefault(name, []).append(0.0 if slid is None else slid)

    def add_joints(self, name: str, joints: Any, facing: Any, palm: Any, take: "Take") -> None:
        """What there is of a follower of whom only joints are known."""
        rate, real = take.leader.sample_rate, facing_of(take.real)
        errors = follower_errors(joints, joint_positions(take.real), joint_positions(take.leader), rate)
        self.errors.setdefault(name, []).append(errors)
        self.wrong.setdefault(name, []).append(wrong_facing(facing, real))
        turns, truth = find_turns(facing, rate), find_turns(real, rate)
        self.turns.setdefault(name, []).append((same_turns(turns, truth), len(turns), len(truth)))
        near = hands_near(palm, palms(take.leader), take.holds)
        self.near.setdefault(name, []).extend([] if near is None else [near])

    def mean(self, name: str, figure: str) -> float:
        """Mean over the takes."""
        return float(np.mean([getattr(one, figure) for one in self.errors[name]]))

    def turn_f1(self, name: str) -> float:
        """Harmonic mean of precision and recall of the turns of all takes."""
        same, made, real = np.sum(self.turns[name], axis=0).tolist()
        return float(2.0 * same / max(made + real, 1))


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """A take that is left out."""

    leader: Clip
    real: Clip
    holds: tuple[Hold, ...]


def rows_of(known: PartnerExamples, takes: tuple[int, ...]) -> list[Row]:
    """All figures."""
    tally = Tally()
    for take in takes:
        _one(known, take, tally)
    return _rows(tally)


def _one(known: PartnerExamples, take: int, tally: Tally) -> None:
    examples = known.units.examples
    others = [one for n, one in enumerate(examples) if n != take]
    units = cut_units(others)
    lead, real = known.leaders[take], known.followers[take].clip
    assert lead is not None  # pairs with leaders
    leader, x = lead.clip, examples[take].control
    out, led = Take(leader, real, examples[take].holds), joint_positions(leader)
    beats = examples[take].beats / leader.sample_rate
    search = SearchSettings()
    expected = expected_follower(leader_cloud(leader), units)
    found = find_partner(leader, x, units, search, expected=expected)
    tally.add("search", found.clip, found.answer.clip.contact, out)
    on_beat = replace(search, beats=beats)
    locked = find_partner(leader, x, units, on_beat, expected=expected)
    tally.add("search, on the beat", locked.clip, locked.answer.clip.contact, out)
    period, first = float(np.diff(beats).mean()), float(beats[0])
    for name, one in (("search", found), ("search, on the beat", locked)):
        away = period_offsets(shown_beats(one.answer, one.reading, units), period, first)
        tally.offsets.setdefault(name, []).extend(np.abs(away).tolist())
    live, told = evaluate_live(leader, x, units, on_beat, time.thread_time)
    tally.add("live", live.clip, live.clip.contact, out)
    tally.live.append(told["live"])
    tally.apart.append(
        [_nearest(one, led) for one in (joint_positions(real), joint_positions(found.clip), joint_positions(live.clip))]
    )
    landed = find_rhythm(real).contact_times
    tally.offsets.setdefault("the real one's feet", []).extend(np.abs(period_offsets(landed, period, first)).tolist())
    leaders = [one.clip for n, one in enumerate(known.leaders) if n != take and one is not None]
    joints, facing = kernel_regression(leader, units, leaders)
    tally.add_joints("kernel regression", joints, facing, joint_palms(joints), out)
    for name, clip in (
        ("nearest unit", nearest_units(x, units, beats)),
        ("nearest frame", nearest_frames(x, units)),
        ("constant offset", constant_offset(leader, units, leaders)),
    ):
        tally.add(name, clip, clip.contact, out)
    tally.add("the real one", real, real.contact, out)


def followed_rows(known: PartnerExamples, takes: tuple[int, ...]) -> list[Row]:
    """No beats given: the examples' are found in both dancers' feet, the leader's in hers alone. What is shown is held
    against the take's own, of both dancers' feet, and against those of the real follower's feet alone."""
    tally, away, apart, real_apart = Tally(), [], [], []
    for take in takes:
        examples = known.units.examples
        units = cut_units([one for n, one in enumerate(examples) if n != take])
        lead, real = known.leaders[take], known.followers[take].clip
        assert lead is not None  # pairs with leaders
        lines = find_two_beat_lines([lead.clip], float(np.median(units.seconds)))
        own = find_two_beat_lines([real])
        assert lines is not None  # these recordings are long enough
        assert own is not None
        last = (real.sample_count - 1.0) / real.sample_rate
        search = SearchSettings(beats=lines.beats(last))
        x, out = examples[take].control, Take(lead.clip, real, examples[take].holds)
        expected = expected_follower(leader_cloud(lead.clip), units)
        found = find_partner(lead.clip, x, units, search, expected=expected)
        tally.add("search", found.clip, found.answer.clip.contact, out)
        live, told = evaluate_live(lead.clip, x, units, search, time.thread_time)
        tally.add("live", live.clip, live.clip.contact, out)
        tally.add("the real one", real, real.contact, out)
        tally.live.append(told["live"])
        shown = shown_beats(found.answer, found.reading, units)
        away.append(beat_offsets(shown, examples[take].beats / real.sample_rate))
        apart.append(beat_offsets(shown, own.beats(last)))
        real_apart.append(beat_offsets(lines.lines, own.lines))
    pair, follower, both = (1000.0 * float(np.median(np.abs(np.concatenate(one)))) for one in (away, apart, real_apart))
    words = "salsa, beats followed:"
    slid = {name: float(np.mean(values)) for name, values in tally.slides.items()}
    return [
        Row(f"{words} joint error", tally.mean("search", "joint_m"), "m",
            peers={"live": tally.mean("live", "joint_m")}),
        Row(f"{words} beat offset", pair, "ms", 40.0, peers={
            "from the real follower's alone": follower, "of the real leader's lines from hers": both,
        }),
        Row(f"{words} live, joint error over the search's",
            100.0 * (tally.mean("live", "joint_m") / tally.mean("search", "joint_m") - 1.0), "%", 15.0),
        Row(f"{words} live, foot slide", slid["live"], "m/s", slid["the real one"] + 0.03, peers=slid),
    ]  # fmt: skip


LATE = 3.0
"""A follower who is later than the leader by this [s] spoils a take."""


def _late(example: Example) -> Example:
    """The take with a follower who is late; her last seconds come first."""
    clip = example.follower
    count = round(LATE * clip.sample_rate)
    moved = {name: np.roll(getattr(clip, name), count, axis=0) for name in ("root_position", "rotation", "contact")}
    follower = replace(clip, **moved)
    return replace(example, name=f"{example.name}, late", follower=follower, target=ends_cloud(follower), holds=())


def _exchanged(example: Example, other: Example) -> Example:
    """The take with the follower of another one, who stands still at the end if hers is shorter."""
    at = np.minimum(np.arange(example.follower.sample_count), other.follower.sample_count - 1)
    moved = {name: getattr(other.follower, name)[at] for name in ("root_position", "rotation", "contact")}
    follower = replace(example.follower, **moved)
    return replace(example, name=f"{example.name}, exchanged", follower=follower, target=ends_cloud(follower), holds=())


def spoiled_rows(known: PartnerExamples, takes: tuple[int, ...]) -> list[Row]:
    """A spoiled take more among the examples (H026): the next one's follower is late, or is that of another take."""
    examples = known.units.examples
    errors: dict[str, list[float]] = {}
    for take in takes:
        others = [one for n, one in enumerate(examples) if n != take]
        spoilt = (take + 1) % len(examples)
        lead, real = known.leaders[take], known.followers[take].clip
        assert lead is not None  # pairs with leaders
        search = SearchSettings(beats=examples[take].beats / real.sample_rate)
        for words, more in (
            ("no spoiled take", []),
            ("a late follower", [_late(examples[spoilt])]),
            ("another take's follower", [_exchanged(examples[spoilt], examples[(spoilt + 3) % len(examples)])]),
        ):
            units = cut_units([*others, *more])
            for weighs in (True, False):
                live, _ = evaluate_live(lead.clip, examples[take].control, units, search, weighs=weighs)
                found = follower_errors(
                    joint_positions(live.clip), joint_positions(real), joint_positions(lead.clip), real.sample_rate
                )
                errors.setdefault(f"{words}, {'weighed' if weighs else 'all alike'}", []).append(found.joint_m)
    mean = {name: float(np.mean(values)) for name, values in errors.items()}
    return [
        Row(f"salsa, live, {words}: joint error", mean[f"{words}, weighed"], "m", bar,
            peers={"all examples alike": mean[f"{words}, all alike"]})
        for words, bar in (
            ("no spoiled take", None),
            ("a late follower", mean["a late follower, all alike"]),
            ("another take's follower", mean["another take's follower, all alike"]),
        )
    ]  # fmt: skip


def _nearest(joints: Any, leader: Any) -> float:
    """How near the hips come over the floor: the 1st percentile [m]."""
    count = min(len(joints), len(leader))
    away = joints[:count, 0] - leader[:count, 0]
    return float(np.percentile(np.hypot(away[:, 0], away[:, 2]), 1.0))


BASELINES = ("nearest unit", "nearest frame", "constant offset")
PEERS = (*BASELINES, "kernel regression")
FIGURES = (
    ("joint_m", "joint error", "m"), ("aligned_m", "joint error, aligned", "m"),
    ("hip_distance_m", "hip distance error", "m"), ("velocity_m_s", "velocity error", "m/s"),
)  # fmt: skip


def _rows(tally: Tally) -> list[Row]:
    rows = []
    for figure, words, unit in FIGURES:
        others = {name: tally.mean(name, figure) for name in (*PEERS, "search, on the beat", "live")}
        bar = None if figure == "aligned_m" else min(others[name] for name in BASELINES)
        rows.append(Row(f"salsa: {words}", tally.mean("search", figure), unit, bar, peers=others))
    raw = float(np.mean(tally.slides["the real one"]))
    slid = {name: float(np.mean(values)) for name, values in tally.slides.items()}
    rows.append(Row("salsa: foot slide", slid["search"], "m/s", raw + 0.03, peers=slid))
    away = {name: 1000.0 * float(np.median(values)) for name, values in tally.offsets.items()}
    rows.append(Row("salsa: beat offset, where beats are known", away["search, on the beat"], "ms", 40.0, peers=away))
    rows.append(Row("salsa, live: joint error over the offline one's (on the beat)",
                    100.0 * (tally.mean("live", "joint_m") / tally.mean("search, on the beat", "joint_m") - 1.0),
                    "%", 15.0))  # fmt: skip
    rows.append(Row("salsa, live: foot slide", slid["live"], "m/s", raw + 0.03))
    names = list(tally.errors)
    for words, unit, bar, figures in (
        (
            "turned more than 90 degrees wrong",
            "%",
            14.0,
            {name: 100.0 * float(np.mean(tally.wrong[name])) for name in names},
        ),
        ("turns of half a turn or more within 2 s, F1", "", 0.7, {name: tally.turn_f1(name) for name in names}),
        (
            "hands within 25 cm while the real ones hold",
            "%",
            55.0,
            {name: 100.0 * float(np.mean(tally.near[name] or [np.nan])) for name in names},
        ),
    ):
        better: Literal["at most", "at least"] = "at most" if words.startswith("turned") else "at least"
        rows.append(Row(f"salsa, live: {words}", figures.pop("live"), unit, bar, better, figures))
    real, offline, live = np.mean(tally.apart, axis=0).tolist()
    rows.append(Row("salsa, live: nearest that hips come (1st percentile)", live, "m",
                    peers={"search": offline, "the real one": real}))  # fmt: skip
    spent = max(one["frame_ms"]["p99"] for one in tally.live)
    rows.append(Row("salsa, live: a frame at 30 Hz, p99", spent, "ms", 1.5))
    return rows


def period_offsets(shown: npt.NDArray[np.float64], period: float, first: float) -> npt.NDArray[np.float64]:
    """Return the signed offsets of shown beats from the nearest beats, `period` [s] apart, one at `first` [s]."""
    phase = (shown - first) / period
    return np.asarray((phase - np.round(phase)) * period)


def joint_palms(joints: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the palms (T, 2, 3) of joints (T, J, 3): beyond the wrists, in line with the lower arms."""
    wrist, elbow = (
        joints[:, [SKELETON.index(f"{side}{part}") for side in ("left", "right")]] for part in ("Hand", "LowerArm")
    )
    along = wrist - elbow
    return np.asarray(wrist + PALM_OFFSET * along / np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9))
