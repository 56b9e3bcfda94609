"""Texturing, speed: a minute of motion from ten minutes of data, stage by stage; and live, for each dancer."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from live.base.motion_parameters import MOTION_SIZE, TEXTURE
from live.cli.bench import Row
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.pose.pose_pipeline import PoseSkeleton
from live.motion.skeleton import JOINT_COUNT, Skeleton
from live.motion.step_clip import StepClip
from live.motion.texture.frequency_bands import sample_clip
from live.motion.texture.live_bank import TextureBank
from live.motion.texture.texture_corpus import make_corpus
from live.motion.texture.texture_settings import TextureSettings
from live.motion.texture.texture_synthesis import find_paths, prepare_sketch, texture_sketch
from live.motion.texture.upper_body_regression import learn_upper_body
from live.show.dancers.live_texture import LiveTexture
from live.show.dancers.variation import Variation

RATE: Final = 60.0
SKETCH_S: Final = 60.0
DATA_S: Final = (60.0,) * 10


def run(full: bool, shared: Path | None) -> list[Row]:
    """On made-up motion, so that it needs no data: angles that sway at the frequencies of dance. Nothing is read."""
    chance = np.random.default_rng(1)
    sketch = _made(SKETCH_S, chance)
    data = [_made(seconds, chance) for seconds in DATA_S]
    wish = TextureSettings()
    repeats = 5 if full else 3
    whole = _best(lambda: texture_sketch(sketch, make_corpus(data, [sample_clip(sketch)]), wish), repeats)
    material = make_corpus(data, [sample_clip(sketch)])
    again = _best(lambda: texture_sketch(sketch, material, wish), repeats)
    cutting = _best(lambda: make_corpus(data, [sample_clip(sketch)]), repeats)
    matching = _best(lambda: prepare_sketch(sketch, replace(material, _driving_cache={}), wish), repeats)
    ready = prepare_sketch(sketch, material, wish)
    finding = _best(lambda: find_paths(ready, wish), repeats)
    naive = _naive(sketch, material, wish)
    takes = [sample_clip(clip) for clip in data]
    learning = _best(lambda: learn_upper_body(takes, wish.synthesize), 1)
    return [
        Row("60 s textured and completed from 10 min, all of it", whole, "s", 1.0),
        Row("the same, data cut up before", again, "s", 1.0),
        Row("cutting up 10 min of data", cutting, "s"),
        Row("bands, fragments and matching", matching, "s", peers={"one pair of fragments after the other": naive}),
        Row("paths", finding, "s"),
        Row("learning what legs tell, from 10 min", learning, "s", 60.0),
        Row("fragments of the sketch", ready.fragments.count, ""),
        Row("fragments of the data", ready.driving.fragments.count, ""),
        *_live(data, full),
        Row("motion made in a second", SKETCH_S / whole, "s", 60.0, "at least"),
    ]


def _live(data: list[Clip], full: bool) -> list[Row]:
    """Legs watched, fragments chosen and upper bodies dressed, at 64 ticks and 60 frames a second and 120 bpm."""
    measure = 2.0 * RATE
    bank = TextureBank.of([StepClip("x", clip, 0.0, measure, int((clip.sample_count - 1) / measure)) for clip in data])
    rows = [Row("live: beats to choose from", bank.count, "")]
    for count in (1, 24, 100) if full else (24, 100):
        ticks, frame = np.min([_live_costs(bank, count) for _ in range(5 if full else 3)], axis=0).tolist()
        name = f"live, {count} dancer{'s' if count > 1 else ''}"
        parts = {"watching and choosing": ticks / count, "dressing": frame / count}
        rows.append(Row(f"{name}: for each and a frame", (ticks + frame) / count, "ms", 0.01, peers=parts))
    return rows


def _live_costs(bank: TextureBank, count: int) -> tuple[float, float]:
    """Milliseconds of processor for all dancers: their ticks for each frame, and a frame."""
    chance = np.random.default_rng(2)
    walk = _made(20.0, chance)
    legs = walk.rotation[:, PoseSkeleton.legs_only()[1]]
    own = PoseSkeleton.legs_only()[0]
    skeleton = Skeleton(tuple(map(str, range(9))), own.parents, own.offsets)
    position, rotation = (a.astype(np.float32) for a in forward_kinematics(walk.root_position, legs, skeleton))
    body, turned = (a.astype(np.float32) for a in forward_kinematics(walk.root_position, walk.rotation))
    values = np.zeros((1, MOTION_SIZE))
    values[0, TEXTURE.first] = 1.0
    variation = Variation(values, np.zeros(count, np.int32), seed=1, beats_per_measure=4, window=1.0)
    texturing = LiveTexture(bank, variation, count, seed=1, beats=4)
    offset = chance.integers(0, 200, count)
    rows = [(number + offset) % 1000 for number in range(64 * 10)]
    poses = [(np.ascontiguousarray(position[at]), np.ascontiguousarray(rotation[at])) for at in rows]
    bodies = [(np.ascontiguousarray(body[at]), np.ascontiguousarray(turned[at])) for at in rows]
    phases = [np.full(count, number / 64.0 / 2.0) for number in range(len(rows))]
    for number in range(128):
        texturing.tick(phases[number], *poses[number], 1.0 / 64.0)
    began = time.process_time()
    for number in range(128, len(rows)):
        texturing.tick(phases[number], *poses[number], 1.0 / 64.0)
    ticked = time.process_time()
    for number in range(128, len(rows)):
        texturing.apply(phases[number], *bodies[number])
    drawn = time.process_time()
    each = 1000.0 / (len(rows) - 128)
    return (ticked - began) * each * 64.0 / 60.0, (drawn - ticked) * each


def _best(work: Callable[[], object], repeats: int) -> float:
    """The least processor time of several [s]: what others on the machine do counts little."""
    least = np.inf
    for _ in range(repeats):
        began = time.process_time()
        work()
        least = min(least, time.process_time() - began)
    return float(least)


def _naive(sketch: Clip, material: object, wish: TextureSettings) -> float:
    """Matching as the paper tells it, each pair by itself, measured for 5 fragments of the sketch, for all [s]."""
    ready = prepare_sketch(sketch, material, wish)  # type: ignore[arg-type]
    parts, driving = ready.fragments, ready.driving
    data = driving.fragments
    began = time.process_time()
    for row in range(5):
        n = int(parts.length[row]) + 1
        own = np.zeros((n, driving.features.shape[1]))
        for begin, end in zip(data.begin.tolist(), data.end.tolist(), strict=True):
            at = np.linspace(begin, end, n)
            low = np.minimum(at.astype(np.int64), len(driving.features) - 2)
            part = (at - low)[:, None]
            there = driving.features[low] * (1.0 - part) + driving.features[low + 1] * part
            float(((own - there) ** 2).sum())
    return (time.process_time() - began) * parts.count / 5


def _made(seconds: float, chance: np.random.Generator) -> Clip:
    """A body whose joints sway with five frequencies each, and which stands on both feet."""
    count = int(seconds * RATE)
    t = np.arange(count)[:, None, None] / RATE
    vector = np.zeros((count, JOINT_COUNT, 3))
    for hertz in (0.2, 0.5, 1.0, 2.0, 4.0):
        frequency = hertz * chance.uniform(0.8, 1.25, (1, JOINT_COUNT, 3))
        phase = chance.uniform(0.0, 2.0 * np.pi, (1, JOINT_COUNT, 3))
        vector += 0.12 / hertz**0.5 * np.sin(2.0 * np.pi * frequency * t + phase)
    rotation = quaternion.from_rotation_vector(vector).astype(np.float32)
    root = np.zeros((count, 3), np.float32)
    root[:, 1] = 0.9
    contact = np.sin(np.arange(count) / RATE * 2.0 * np.pi)[:, None] * (1.0, -1.0) > 0.0
    return Clip("made up", root, rotation, RATE, contact)
