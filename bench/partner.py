"""Partners by example on real salsa: each take answered from the others (H022), beside simpler followers."""

import json
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from bench import texture_quality
from bench._partner_baselines import constant_offset, nearest_frames, nearest_units
from live.cli.bench import Row
from live.library.partner_pairs import PartnerExamples, read_pairs
from live.motion.beats.dance_rhythm import find_rhythm
from live.motion.beats.tempo_estimation import find_two_beat_lines
from live.motion.clip import Clip
from live.motion.partner.decoder import Reading
from live.motion.partner.evaluation import FollowerErrors, follower_errors, joint_positions, slide_metrics
from live.motion.partner.partner_synthesis import SearchSettings, find_partner, shown_beats
from live.motion.partner.units import cut_units
from live.motion.partner_live.live_partner import evaluate_live
from live.motion.quality.metrics import beat_offsets

DROPPED = 6
"""Frames of a T-pose and the run-in from it."""
LAGS = (0.0, 0.25, 0.5, 1.0, 1.5, 2.0)
"""Units after the middle of each at which it is asked what is known of it."""
OTHER_RATE = 10.0
"""Frames per second of a second offline search: how far the offline optimum agrees with itself."""
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
    return [*rows_of(known, left_out), *followed_rows(followed, left_out)]


def _read(pairs: str) -> PartnerExamples:
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(pairs)
        file.flush()
        return read_pairs(Path(file.name))


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
        self.live: list[dict[str, Any]] = []
        self.lags: list[Any] = []
        self.itself: list[float] = []
        self.apart: list[list[float]] = []

    def add(self, name: str, clip: Clip, contact: Any, truth: Any, leader: Any) -> None:
        """A follower of one take."""
        joints = joint_positions(clip)
        self.errors.setdefault(name, []).append(follower_errors(joints, truth, leader, clip.sample_rate))
        slid = slide_metrics(joints, contact, clip.sample_rate)["foot_slide_mean"]
        self.slides.setdefault(name, []).append(0.0 if slid is None else slid)

    def mean(self, name: str, figure: str) -> float:
        """Mean over the takes."""
        return float(np.mean([getattr(one, figure) for one in self.errors[name]]))


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
    truth, led = joint_positions(real), joint_positions(leader)
    beats = examples[take].beats / leader.sample_rate
    search = SearchSettings()
    found = find_partner(leader, x, units, search)
    tally.add("search", found.clip, found.answer.clip.contact, truth, led)
    on_beat = replace(search, beats=beats)
    locked = find_partner(leader, x, units, on_beat)
    tally.add("search, on the beat", locked.clip, locked.answer.clip.contact, truth, led)
    period, first = float(np.diff(beats).mean()), float(beats[0])
    for name, one in (("search", found), ("search, on the beat", locked)):
        away = period_offsets(shown_beats(one.answer, one.reading, units), period, first)
        tally.offsets.setdefault(name, []).extend(np.abs(away).tolist())
    live, told = evaluate_live(leader, x, units, on_beat, time.thread_time)
    tally.add("live", live.clip, live.answer.clip.contact, truth, led)
    tally.live.append(told["live"])
    tally.apart.append([_nearest(one, led) for one in (truth, joint_positions(found.clip), joint_positions(live.clip))])
    landed = find_rhythm(real).contact_times
    tally.offsets.setdefault("the real one's feet", []).extend(np.abs(period_offsets(landed, period, first)).tolist())
    tally.lags.append(agreement_by_lag(x, units, on_beat, locked.reading, LAGS, similar_units(units)))
    scale = OTHER_RATE / search.rate
    again = find_partner(leader, x, units, replace(on_beat, rate=OTHER_RATE, k=search.k * scale))
    tally.itself.append(agreement_of(again.reading, locked.reading))
    leaders = [one.clip for n, one in enumerate(known.leaders) if n != take and one is not None]
    for name, clip in (
        ("nearest unit", nearest_units(x, units, beats)),
        ("nearest frame", nearest_frames(x, units)),
        ("constant offset", constant_offset(leader, units, leaders)),
    ):
        tally.add(name, clip, clip.contact, truth, led)
    tally.add("the real one", real, real.contact, truth, led)


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
        x, truth, led = examples[take].control, joint_positions(real), joint_positions(lead.clip)
        found = find_partner(lead.clip, x, units, search)
        tally.add("search", found.clip, found.answer.clip.contact, truth, led)
        live, told = evaluate_live(lead.clip, x, units, search, time.thread_time)
        tally.add("live", live.clip, live.answer.clip.contact, truth, led)
        tally.add("the real one", real, real.contact, truth, led)
        tally.live.append(told["live"])
        shown = shown_beats(found.answer, found.reading, units)
        away.append(beat_offsets(shown, examples[take].beats / real.sample_rate))
        apart.append(beat_offsets(shown, own.beats(last)))
        real_apart.append(beat_offsets(lines.lines, own.lines))
    pair, follower, both = (1000.0 * float(np.median(np.abs(np.concatenate(one)))) for one in (away, apart, real_apart))
    agreed = 100.0 * float(np.mean([one["agreement"] for one in tally.live]))
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
        Row(f"{words} live, units as the offline search has them", agreed, "%", 85.0, "at least"),
    ]  # fmt: skip


def _nearest(joints: Any, leader: Any) -> float:
    """How near the hips come over the floor: the 1st percentile [m]."""
    count = min(len(joints), len(leader))
    away = joints[:count, 0] - leader[:count, 0]
    return float(np.percentile(np.hypot(away[:, 0], away[:, 2]), 1.0))


BASELINES = ("nearest unit", "nearest frame", "constant offset")
FIGURES = (
    ("joint_m", "joint error", "m"), ("aligned_m", "joint error, aligned", "m"),
    ("hip_distance_m", "hip distance error", "m"), ("velocity_m_s", "velocity error", "m/s"),
)  # fmt: skip


def _rows(tally: Tally) -> list[Row]:
    rows = []
    for figure, words, unit in FIGURES:
        others = {name: tally.mean(name, figure) for name in (*BASELINES, "search, on the beat", "live")}
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
    committed = float(np.median([one["committed_at"]["median"] for one in tally.live]))
    rows.append(Row("salsa, live: share of a unit that is over when it is decided", committed, "", 0.5))
    strict, same = (100.0 * float(np.mean([one[key] for one in tally.live])) for key in
                    ("agreement", "agreement_alike"))  # fmt: skip
    itself = {"the offline search itself, at 10 Hz": 100.0 * float(np.mean(tally.itself))}
    rows.append(Row("salsa, live: units as the offline search has them", strict, "%", 85.0, "at least", itself))
    rows.append(Row("salsa, live: those, or units within 0.2 m of them", same, "%"))
    rows += [
        Row(f"salsa, live: units known when {0.5 + lag:g} of each are over", 100.0 * one, "%",
            peers={"or units within 0.2 m of them": 100.0 * other})
        for lag, (one, other) in zip(LAGS, np.mean(tally.lags, axis=0).tolist(), strict=True)
    ]  # fmt: skip
    real, offline, live = np.mean(tally.apart, axis=0).tolist()
    rows.append(Row("salsa, live: nearest that hips come (1st percentile)", live, "m",
                    peers={"search": offline, "the real one": real}))  # fmt: skip
    spent = max(one["frame_ms"]["p99"] for one in tally.live)
    rows.append(Row("salsa, live: a frame at 30 Hz, p99", spent, "ms", 12.0))
    return rows


def period_offsets(shown: npt.NDArray[np.float64], period: float, first: float) -> npt.NDArray[np.float64]:
    """Return the signed offsets of shown beats from the nearest beats, `period` [s] apart, one at `first` [s]."""
    phase = (shown - first) / period
    return np.asarray((phase - np.round(phase)) * period)


def agreement_of(reading: Reading, offline: Reading) -> float:
    """Return the `agreement` of another reading of the same input instead of the danced units."""
    times = np.arange(int((reading.start[-1] + reading.duration[-1]) / reading.rate * LIVE_RATE) + 1) / LIVE_RATE
    which = np.maximum(np.searchsorted(reading.start, times * reading.rate + 1e-9, side="right") - 1, 0)
    return agreement([(int(reading.unit[n]), int(reading.start[n])) for n in which], offline)
