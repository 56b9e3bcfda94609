"""Texturing, quality: upper bodies held out and made anew from the legs, beside the mean pose and an unmatched clip.

Copies of a take (dancers in unison, the same step danced twice) are never in the data when it is held out. Held out are
takes, all takes of a dancer, and whole dances.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.cli.bench import Row
from live.library.capture_material import NO_BEAT_TAG, read_material
from live.motion import quaternion
from live.motion.clip import Clip, read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quaternion import mean_rotation
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.coordination import coordination_of, correlation
from live.motion.texture.frequency_bands import columns_of, sample_clip, split_bands, tracks_of
from live.motion.texture.live_bank import TextureBank, leg_positions
from live.motion.texture.live_prediction import EIGHTH, leg_windows
from live.motion.texture.live_texture_kernels import DERIVATIVE, PER_BEAT, nearest_fragment
from live.motion.texture.take_splits import choreographies, find_copies
from live.motion.texture.texture_corpus import make_corpus
from live.motion.texture.texture_settings import JOINT_GROUPS, UPPER, TextureSettings
from live.motion.texture.texture_synthesis import texture_sketch
from live.motion.texture.upper_body_regression import UpperBodyRegression
from live.show.dancers.live_texture import SWITCH_COST

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

SETS: Final = {
    "walk": (("walk/cmu_02_01_walk.bvh", "walk/cmu_12_01_walk.bvh", "walk/figure8_MS2_8Walk_M.bvh"), None, 4),
    "salsa leader": (tuple(f"salsa/60_0{n}.bvh" for n in range(1, 8)), 60.0, 4),
    "one routine": (tuple(f"group/perfume_{n}.bvh" for n in ("aachan", "kashiyuka", "nocchi")), None, 5),
    "modern": (
        tuple(f"solo/modern05/05_{n}.bvh" for n in ("02", "06", "09", "10", "13", "14", "15", "18", "19")),
        None,
        5,
    ),
}
"""Recordings, their true rate, and the band that is matched. Each is held out in turn; the others, without its copies,
are the data. The dancers of the routine are copies of each other: it has data only as a whole dance."""
FOREIGN: Final = {
    "modern, another dancer's data": ("modern", tuple(f"asfamc/49_{n}.amc" for n in (10, 11, 12, 14)), None),
    "salsa leader, another dancer's data": ("salsa leader", tuple(f"salsa/61_0{n}.bvh" for n in range(1, 8)), 60.0),
}
"""Held-out sets with recordings of another dancer of this dance as data, and their rate."""
MAX_RATIO: Final = 0.95
MIN_IN_TIME: Final = 0.4
"""Bars of unseen takes: error against the mean pose's, and correlation of the arms."""
JUDGED: Final = ("walk", "salsa leader", "modern")
QUICK: Final = {"walk": 2, "salsa leader": 2, "one routine": 1, "modern": 2}
"""How many are held out where not everything is measured."""
BANDS: Final = slice(1, 6)
"""Bands 2 to 6: what is compared of spectra."""
PREFIX_MOMENTS: Final = np.arange(-8, 5, 2)
BEAT_MOMENTS: Final = np.arange(-8, 17, 2)
"""Samples about a beat line, of 16 a beat, at which legs are compared: as on stage, and with the whole beat known."""
FLOOR_DEG: Final = 0.01
"""A band with less is as good as still."""
COORDINATED: Final = JOINT_GROUPS["shoulders"]
"""Joints whose band is correlated with the real one's."""
ELBOWS_HANDS: Final = tuple(n for n, one in enumerate(UPPER) if SKELETON.names[one].endswith(("LowerArm", "Hand")))
"""Rows of elbows and hands among the upper joints."""


@dataclass(frozen=True, slots=True)
class Figures:
    """What one upper body is like, against the real one."""

    error_cm: float
    """Mean distance of the upper joints, hips laid on hips."""
    spectrum_db: float
    """Mean difference of the levels of bands 2 to 6."""
    follows: float
    """Correlation of the arms' matched band with the real one's: how well they are in time."""
    hands_follow: float
    """The same of the places of elbows and hands, seen from the hips. Unlike angles, it does not depend on how bones
    are twisted in a recording, nor on the axes of angles."""
    apart: float
    """Distance of the couplings of left and right arm, and of arms and steps, from the real ones: 0 to 2."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """On the recordings in `shared`/mocap."""
    rows: list[Row] = []
    for name in SETS:
        rows += _compared(name, name, _held_out(name, full, shared))
        rows += _live(name, full, shared)
    for label, (name, files, fps) in FOREIGN.items():
        rows += _compared(label, name, _foreign(name, files, fps, full, shared))
    for name in SETS:
        others = [one for one in SETS if one != name]
        rows += _compared(f"{name}, whole dance left out", name, _other_dances(name, others, full, shared))
    for name in SETS if full else ("walk", "salsa leader"):
        for label, change in _ablations(SETS[name][2]):
            rows += _ablated(name, label, change, full, shared)
    return rows


def _ablations(band: int) -> Iterator[tuple[str, dict[str, object]]]:
    for keep in (1.0, 0.02, 0.1, 0.3):
        yield f"K {'1' if keep == 1.0 else f'{keep:.0%} of the fragments'}", {"keep": keep}
    for other in (2, 3, 4, 5, 6, 7):
        yield f"band {other}", {"match_band": other}
    hips, knees = JOINT_GROUPS["hips"], JOINT_GROUPS["knees"]
    drivers = {"hips": hips, "knees": knees, "left hip and knee": (hips[0], knees[0]), "hips and knees": hips + knees}
    for label, drive in drivers.items():
        yield f"driven by {label}", {"drive": drive}
    for weight in (0.0, 1.0, 3.0):
        yield f"derivative {weight:g}", {"derivative": weight}
    yield "scaled", {"scale": True}
    for cost in (0.5, 2.0, 8.0):
        yield f"joins weighed {cost:g}", {"join_weight": cost}


def _held_out(name: str, full: bool, shared: Path | None) -> Iterator[tuple[Clip, list[Clip]]]:
    for real, data in _held_out_steps(name, full, shared):
        yield real.clip, [one.clip for one in data]


def _held_out_steps(name: str, full: bool, shared: Path | None) -> Iterator[tuple[StepClip, list[StepClip]]]:
    clips = _recordings(*SETS[name][:2], shared)
    if not clips:
        return
    dance = choreographies(len(clips), find_copies([sample_clip(one.clip) for one in clips])).number
    for index in range(len(clips) if full else QUICK[name]):
        data = [clip for n, clip in enumerate(clips) if dance[n] != dance[index]]
        if data:
            yield clips[index], data


def _recordings(files: Sequence[str], fps: float | None, shared: Path | None) -> list[StepClip]:
    places = [] if shared is None else [shared / "mocap" / file for file in files]
    if not all(place.is_file() for place in places):
        return []
    return [read_material([place], fps=fps).clips[0] for place in places]


def _foreign(
    name: str, files: Sequence[str], fps: float | None, full: bool, shared: Path | None
) -> Iterator[tuple[Clip, list[Clip]]]:
    data = [one.clip for one in _recordings(files, fps, shared)]
    for real in _recordings(*SETS[name][:2], shared)[: None if full else 1]:
        if data:
            yield real.clip, data


def _other_dances(
    name: str, others: Sequence[str], full: bool, shared: Path | None
) -> Iterator[tuple[Clip, list[Clip]]]:
    data = [one.clip for other in others for one in _recordings(*SETS[other][:2], shared)]
    for real in _recordings(*SETS[name][:2], shared)[: None if full else 1]:
        if data:
            yield real.clip, data


def _wish(name: str, **change: object) -> TextureSettings:
    return replace(TextureSettings(texture=(), match_band=SETS[name][2]), **change)  # type: ignore[arg-type]


def _compared(label: str, name: str, held_out: Iterator[tuple[Clip, list[Clip]]]) -> list[Row]:
    found: dict[str, list[Figures]] = {}
    learnt: tuple[list[Clip], UpperBodyRegression] | None = None
    for real, data in held_out:
        material = make_corpus(data, [sample_clip(real)])
        wish = _wish(name, join_weight=2.0)
        settings = replace(wish, learnt=True)
        if learnt is not None and learnt[0] is data:  # the same data for all takes: learnt once
            material.keep_regression(settings, learnt[1])
        clips = {
            "made": texture_sketch(real, material, settings)[0].clip,
            "told by the legs alone": texture_sketch(real, material, replace(settings, spread=0.0))[0].clip,
            "joins weighed": texture_sketch(real, material, wish)[0].clip,
            "as published": texture_sketch(real, material, _wish(name))[0].clip,
            "mean pose": _mean(real, data),
            "unmatched clip": _unmatched(real, data),
        }
        learnt = data, material.regression(settings)
        for kind, clip in clips.items():
            found.setdefault(kind, []).append(_figures(real, clip, material, SETS[name][2]))
    return [*_rows(label, found), _ratio(label, found, judged=label in JUDGED)]


def _ratio(label: str, found: dict[str, list[Figures]], *, judged: bool) -> Row:
    """Error against the mean pose's: below 1, legs tell something."""
    means = {kind: float(np.mean([one.error_cm for one in v])) for kind, v in found.items()}
    peers = {kind: means[kind] / means["mean pose"] for kind in means if kind not in ("made", "mean pose")}
    value = means["made"] / means["mean pose"] if means else None
    name = f"{label}: error, of the mean pose's"
    return Row(name, value, "", MAX_RATIO if judged else None, peers=peers)


def _live(name: str, full: bool, shared: Path | None) -> list[Row]:
    """Chosen beat by beat from what the legs did until a quarter of it, as on stage, beside knowing the whole beat."""
    found: dict[str, list[Figures]] = {"made": [], "with the whole beat known": []}
    agreed: list[float] = []
    for real, data in _held_out_steps(name, full, shared):
        if NO_BEAT_TAG in real.tags:
            continue
        try:
            bank = TextureBank.of([one for one in data if NO_BEAT_TAG not in one.tags])
        except ValueError:
            continue
        chosen = []
        for label, moments in (("made", PREFIX_MOMENTS), ("with the whole beat known", BEAT_MOMENTS)):
            clip, made, fragments = _beat_by_beat(real, data, bank, moments)
            material = make_corpus([one.clip for one in data], [sample_clip(clip)])
            found[label].append(_figures(clip, made, material, SETS[name][2]))
            chosen.append(fragments)
        agreed.append(float(np.mean(np.array(chosen[0]) == np.array(chosen[1]))))
    rows = _rows(f"{name}, live", found)
    return [
        *rows,
        Row(f"{name}, live: as with the whole beat known", float(np.mean(agreed)) if agreed else None, "share"),
    ]


def _beat_by_beat(
    real: StepClip, data: Sequence[StepClip], bank: TextureBank, moments: npt.NDArray[np.int64]
) -> tuple[Clip, Clip, list[int]]:
    """The real clip at 16 samples a beat, with the upper body that is chosen for it, and the fragments chosen.

    `moments` are what is compared, in samples about the beat line.
    """
    beats = [_at_beats(one) for one in data]
    legs = np.concatenate([leg_positions(rotation) for rotation, _ in beats if len(rotation) > 3 * PER_BEAT])
    theirs = _features(legs, bank.begin, bank.clip_first, moments).astype(np.float32)
    rotation, rate = _at_beats(real)
    own = leg_positions(rotation)
    lines = np.arange(1, len(rotation) // PER_BEAT - 1)
    mine = _features(own, (lines * PER_BEAT).astype(np.int32), np.zeros(len(lines), np.int32), moments)
    made, last, fragments = rotation.copy(), -1, []
    far = np.empty(bank.count, np.float32)
    join = SWITCH_COST * 2.0 * float(theirs.var(axis=1).sum())
    first_choice = PER_BEAT + PER_BEAT // 4
    for row, line in enumerate(lines.tolist()):
        going = (
            last + 1
            if last >= 0 and last + 1 < bank.count and bank.clip_first[last + 1] == bank.clip_first[last]
            else -1
        )
        prefix = np.ascontiguousarray(mine[:, row], np.float32)
        last = int(nearest_fragment(far, theirs, prefix, going, join, 0.0, 0, 0))
        fragments.append(last)
        first = line * PER_BEAT + PER_BEAT // 4
        at = np.arange(first, len(rotation))
        taken = np.minimum(bank.begin[last] + at - line * PER_BEAT, bank.clip_last[last])
        made[first:, list(UPPER)] = bank.upper[taken]
    told = _told(bank, own)
    made[first_choice:, list(UPPER)] = quaternion.mul(told, made[:, list(UPPER)])[first_choice:]
    still, contact = np.zeros((len(rotation), 3), np.float32), np.zeros((len(rotation), 2), np.bool_)
    clips = [Clip("beats", still.copy(), one.astype(np.float32), rate, contact.copy()) for one in (rotation, made)]
    return clips[0], clips[1], fragments


def _told(bank: TextureBank, legs: Float64) -> Float64:
    """What the bank tells from the legs at every sample, as on stage: turns of the upper joints, (T, 13, 4)."""
    moments = np.arange(0, len(legs), EIGHTH)
    vectors = bank.told.predict(leg_windows(legs, (0, len(legs)))[moments])
    at = np.arange(len(legs))
    last, part = at // EIGHTH, (at % EIGHTH / EIGHTH)[:, None]
    weights = 0.5 * (1.0 - part) ** 2, 0.5 + part * (1.0 - part), 0.5 * part**2
    told = sum(weight * vectors[np.maximum(last - 2 + n, 0)] for n, weight in enumerate(weights))
    return np.asarray(quaternion.from_rotation_vector(np.asarray(told).reshape(len(legs), -1, 3)))


def _at_beats(step: StepClip) -> tuple[Float64, float]:
    """Rotations at 16 samples a beat from the first beat on, and how many that are a second."""
    beat = step.samples_per_measure / step.beats_per_measure
    beats = int((step.clip.sample_count - 1 - step.first) / beat + 1e-9)
    _, rotation, _ = read_clip(step.clip, step.first + np.arange(beats * PER_BEAT + 1) * (beat / PER_BEAT))
    return np.asarray(rotation, np.float64), PER_BEAT * step.clip.sample_rate / beat


def _features(
    legs: Float64, begin: npt.NDArray[np.int32], first: npt.NDArray[np.int32], moments: npt.NDArray[np.int64]
) -> Float64:
    at = np.maximum(begin[None] + moments[:, None], first[None])
    places = legs[np.minimum(at, len(legs) - 1)]
    both = np.concatenate((places, DERIVATIVE * np.diff(places, axis=0)))
    return np.asarray(both.transpose(0, 2, 1).reshape(-1, len(begin)))


def _ablated(name: str, label: str, change: dict[str, object], full: bool, shared: Path | None) -> list[Row]:
    figures = []
    for real, data in _held_out(name, full, shared):
        material = make_corpus(data, [sample_clip(real)])
        made = texture_sketch(real, material, _wish(name, **change))[0].clip
        figures.append(_figures(real, made, material, SETS[name][2]))
    return _rows(f"{name}, {label}", {"made": figures})


def _rows(name: str, found: dict[str, list[Figures]]) -> list[Row]:
    rows = []
    for field, words, unit in (
        ("error_cm", "error", "cm"), ("spectrum_db", "spectrum", "dB"), ("follows", "arms in time", "correlation"),
        ("hands_follow", "elbows and hands in time", "correlation"),
        ("apart", "coordination, distance from the real one", "0 to 2"),
    ):  # fmt: skip
        means = {k: float(np.mean([getattr(one, field) for one in v])) for k, v in found.items() if v}
        value = means.pop("made", None)
        if field == "follows" and name in JUDGED:
            rows.append(Row(f"{name}: {words}", value, unit, MIN_IN_TIME, "at least", peers=means))
        else:
            rows.append(Row(f"{name}: {words}", value, unit, peers=means))
    return rows


def _figures(real: Clip, made: Clip, material: object, band: int) -> Figures:
    a, b = (_upper(clip.rotation) for clip in (real, made))
    charts = material.charts  # type: ignore[attr-defined]
    columns = columns_of(UPPER)
    levels, waves, hands = [], [], []
    for clip in (real, made):
        sampled = sample_clip(clip)
        tracks = tracks_of(sampled, charts)
        bands = split_bands(tracks[:, columns], 6)
        levels.append(np.maximum(np.degrees(np.sqrt((bands[BANDS] ** 2).mean(axis=(1, 2)))), FLOOR_DEG))
        waves.append(split_bands(tracks[:, columns_of(COORDINATED)], band)[band - 1])
        places = _upper(sampled.rotation)[:, ELBOWS_HANDS]
        hands.append(split_bands(places.reshape(len(places), -1), band)[band - 1])
    return Figures(
        error_cm=100.0 * float(np.linalg.norm(a - b, axis=-1).mean()),
        spectrum_db=float(np.abs(20.0 * np.log10(levels[1] / levels[0])).mean()),
        follows=correlation(waves[0], waves[1]),
        hands_follow=correlation(hands[0], hands[1]),
        apart=coordination_of(real, band).distance(coordination_of(made, band)),
    )


def _upper(rotations: Float) -> Float64:
    """Upper joints in the axes of the hips, (T, n, 3) [m], of rotations (T, J, 4)."""
    rotation = rotations.astype(np.float64)
    rotation[:, 0] = (1.0, 0.0, 0.0, 0.0)
    position, _ = forward_kinematics(np.zeros((len(rotation), 3)), rotation)
    return np.asarray(position[:, list(UPPER)])


def _mean(real: Clip, data: Sequence[Clip]) -> Clip:
    rotation = real.rotation.copy()
    rotation[:, list(UPPER)] = mean_rotation(np.concatenate([clip.rotation for clip in data]))[list(UPPER)]
    return replace(real, rotation=rotation)


def _unmatched(real: Clip, data: Sequence[Clip]) -> Clip:
    """The upper body of the data as it comes, from its first third on, whatever the legs do; there and back."""
    whole = np.concatenate([clip.rotation for clip in data])
    at = (np.arange(real.sample_count) + len(data[0].rotation) // 3) % (2 * len(whole) - 2)
    rotation = real.rotation.copy()
    rotation[:, list(UPPER)] = whole[np.where(at < len(whole), at, 2 * len(whole) - 2 - at)][:, list(UPPER)]
    return replace(real, rotation=rotation)
