"""Moods (T143): whether a reader of positions alone tells them apart on steps it was not trained on, and feet stay.

Each step of the shipped vocabulary is danced by one dancer without a mood and by one at each end of each mood. The
reader knows joint positions at 60 pictures a second: posture, speed and jerk. After training on all other steps it says
of two performances of one step which is the stronger, the more sudden, the more awake one; and of one which end it is.
"""

import time
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from bench._locomotion_run import engine_of
from live.base.motion_parameters import MOOD_NAMES
from live.base.stage_snapshot import StageView
from live.cli.bench import Row
from live.library.step_folder import load_folder
from live.motion.quality.metrics import StandingFeet
from live.motion.skeleton import SKELETON
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES

Float64 = npt.NDArray[np.float64]

FPS: Final = 60
BPM: Final = 112.0
SETTLE_S: Final = 2.0
SECONDS: Final = 6.5
TOLD: Final = ("weight", "time", "energy")
"""The moods that the reader must tell apart."""
BAR: Final = 0.8
COST_FRAMES: Final = 600
SHRINK: Final = 0.01
"""Share by which the features' variances are enlarged, for the discriminant of few steps."""
_HEAD: Final = """
name = "moods"
seed = 3
steps = "{folder}"
[clock]
bpm = {bpm}
beats_per_measure = {beats}
[stage]
width = 40.0
depth = 6.0
[motion]
warp_beats = 0.0
amplitude = 0.0
mirror = "never"
"""
_GROUP: Final = """
[[group]]
name = "g{number}"
dancers = 1
steps = ["{step}"]
centre = [{x}, 0.0]
size = [1.0, 1.0]
mood = {{ {mood} }}
"""


def run(full: bool, shared: Path | None) -> list[Row]:
    """All shipped steps if `full`, else those of the first show."""
    folders = sorted(PATCHES.glob("*/steps")) if full else []
    steps = [(folder, name, beats) for folder in (PATCHES / "steps", *folders) for name, beats in _steps(folder)]
    danced = [performances(folder, name, beats) for folder, name, beats in steps]
    seen = np.array([[features(one) for one in each] for each in danced])
    rows = []
    for number, mood in enumerate(MOOD_NAMES):
        found = told_apart(seen[:, 1 + 2 * number : 3 + 2 * number])
        rows.append(Row(f"{mood} told apart on unseen steps", found, "", BAR if mood in TOLD else None, "at least"))
    rows.append(Row("which of the twelve ends it is, on unseen steps", named(seen), "", BAR, "at least"))
    slides = [np.concatenate([slide(each[k]) for each in danced]) for k in range(1 + 2 * len(MOOD_NAMES))]
    for name, bar, figure in (("mean", 0.03, np.mean), ("p99", 0.15, lambda values: np.percentile(values, 99))):
        usual, *moods = (float(figure(values)) for values in slides)
        peers = {"without a mood": usual}
        rows.append(Row(f"slide by positions in the worst mood, {name}", max(moods), "m/s", bar, peers=peers))
    rows += [Row("frame of 100 dancers in all moods, times without", frame_cost(), "×")]
    return [Row("steps", float(len(steps)), ""), *rows]


def frame_cost() -> float:
    """Return how many times longer a frame of the first show's steps takes for 100 dancers in all moods at once."""
    head = _HEAD.format(bpm=BPM, beats=4, folder=PATCHES / "steps")
    all_moods = ", ".join(f"{name} = 0.7" for name in MOOD_NAMES)
    group = _GROUP.replace("dancers = 1", "dancers = 100").replace("[1.0, 1.0]", "[30.0, 5.0]")
    shows = []
    for mood in ("", all_moods):
        text = head + group.format(number=0, step="groove", x=0.0, mood=mood)
        engine, clock, _ = engine_of(load_from_patch(parse_patch(text, "moods"), PATCHES / "moods.toml").start())
        shows.append((engine, clock))
    took = np.zeros((COST_FRAMES, 2))
    for frame in range(COST_FRAMES):
        for number, (engine, clock) in enumerate(shows):  # in turn, so that the machine's pace is the same for both
            clock.set(frame / FPS)
            begin = time.perf_counter()
            engine.frame(lambda view: None)
            took[frame, number] = time.perf_counter() - begin
    plain, moods = np.median(took[COST_FRAMES // 4 :], axis=0)
    return float(moods / plain)


def slide(position: Float64) -> Float64:
    """Return the speeds over the floor [m/s] of feet that stand, (n,), of joints (T, J, 3)."""
    feet = StandingFeet(FPS)
    for joints in position:
        feet.add(joints[None])
    return feet.speeds()


def _steps(folder: Path) -> list[tuple[str, int]]:
    return list({clip.step: clip.beats_per_measure for clip in load_folder(folder)}.items())


def performances(folder: Path, step: str, beats: int) -> Float64:
    """Return the joints [m] of a step danced without a mood, then at the lower and upper end of each, (13, T, J, 3)."""
    moods = ["", *(f"{name} = {end}" for name in MOOD_NAMES for end in (-1.0, 1.0))]
    text = _HEAD.format(bpm=BPM, beats=beats, folder=folder)
    for number, mood in enumerate(moods):
        text += _GROUP.format(number=number, step=step, x=2.5 * (number - 6), mood=mood)
    loaded = load_from_patch(parse_patch(text, "moods"), folder.parent / "moods.toml")
    engine, clock, _ = engine_of(loaded.start())
    pictures: list[Float64] = []

    def keep(view: StageView) -> None:
        pictures.append(view.joint_position.astype(np.float64))

    for frame in range(int((SETTLE_S + SECONDS) * FPS)):
        clock.set(frame / FPS)
        engine.frame(keep)
    return np.stack(pictures[int(SETTLE_S * FPS) :], axis=1)[: len(moods)]  # without the reserve


def features(position: Float64) -> Float64:
    """Return what a reader of joints (T, J, 3) [m] sees, (9,): posture [m], logarithms of speed, jerk and size."""
    at = {name: position[:, SKELETON.index(name)] for name in ("hips", "neck", "head", "leftHand", "rightHand")}
    feet = position[:, [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")]]
    hands = np.stack([at["leftHand"] - at["hips"], at["rightHand"] - at["hips"]])
    speed = np.linalg.norm(np.diff(hands, axis=1), axis=-1) * FPS
    jerk = np.linalg.norm(np.diff(hands, 3, axis=1), axis=-1) * FPS**3
    height = at["hips"][:, 1] - feet[..., 1].min(axis=1)
    lean = np.linalg.norm((at["neck"] - at["hips"])[:, (0, 2)], axis=1)
    return np.array([
        height.mean(), lean.mean(), (at["head"] - at["hips"])[:, 1].mean(), hands[..., 1].mean(),
        np.log(speed.mean()), np.log(np.percentile(speed, 95)), np.log(np.percentile(speed, 25) / speed.mean()),
        np.log(jerk.mean()), np.log(hands.std(axis=1).mean()),
    ])  # fmt: skip


def told_apart(seen: Float64) -> float:
    """Return the share of steps whose two performances are told apart by a reader trained on the others.

    `seen` (N, 2, F): features at the lower and the upper end of a mood.
    """
    apart = seen[:, 1] - seen[:, 0]
    right = 0
    for step in range(len(apart)):
        others = np.delete(apart, step, axis=0)
        weight = others.mean(axis=0) / (others.var(axis=0) + 1e-6)
        right += int(weight @ apart[step] > 0.0)
    return right / len(apart)


def named(seen: Float64) -> float:
    """Return the share of performances whose mood and end are named by a reader trained on the other steps.

    `seen` (N, K + 1, F): features without a mood, and at each of K ends. The reader is a linear discriminant.
    """
    change = seen[:, 1:] - seen[:, :1]
    right = 0
    for step in range(len(change)):
        others = np.delete(change, step, axis=0)
        mean = others.mean(axis=0)
        rest = (others - mean).reshape(-1, others.shape[-1])
        spread = rest.T @ rest / len(rest)
        off = (change[step][:, None] - mean) @ np.linalg.cholesky(
            np.linalg.inv(spread + SHRINK * np.diag(np.diag(spread)))
        )
        right += int((np.linalg.norm(off, axis=-1).argmin(axis=1) == np.arange(len(mean))).sum())
    return right / change[..., 0].size
