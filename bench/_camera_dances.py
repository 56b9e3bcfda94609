"""What is danced in made films of cameras: recorded takes, and shows of the project's own steps, as clips.

All clips of a dance have one rate and one world: metres, the floor at y = 0, the dance about the stage's middle.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from bench._motion_clips import recordings
from live.base.arrays import Bool, Float64
from live.clock.ticks import TICK
from live.motion import quaternion
from live.motion.clip import Clip, resample
from live.motion.foot_contact import find_contacts
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.skeleton import SKELETON
from live.show.loader import load_show
from live.show.patch.patch_search_path import PATCHES

RATE: Final = 64.0
"""Samples per second of all clips: one for each tick of a show."""
LEAD: Final = 0.125
"""Time before the film that clips begin with, and end with after it [s]: sub-frames of its first picture need it."""
_ANKLES: Final = [SKELETON.index("leftFoot"), SKELETON.index("rightFoot")]
_BALLS: Final = [SKELETON.index("leftToes"), SKELETON.index("rightToes")]


@dataclass(frozen=True, slots=True)
class Take:
    """A part of recorded takes that share one world, one file for each dancer, or of the same file danced by one."""

    files: tuple[str, ...]
    """Names below the folder of recordings, as `salsa/60_01.bvh`."""
    start: float = 0.0
    """Where the part begins [s]."""
    turn_deg: float = 0.0
    """By which the whole dance is turned about the stage's middle, as a heading."""
    apart: tuple[tuple[float, float], ...] = ()
    """Where each dancer is moved (x, z) [m] instead of where the take has them: the middle of their way."""


@dataclass(frozen=True, slots=True)
class ShowPart:
    """A part of a show without its picture, danced by some of its dancers."""

    patch: str
    """A patch below the folder of patches, as `salsa/show.toml`, or the text of one."""
    dancers: tuple[int, ...]
    """Dancers of the show, from 0."""
    start: float = 0.0
    """Where the part begins [s]."""
    seed: int = 1
    bpm: float | None = None
    """Tempo; None: the patch's."""
    turn_deg: float = 0.0


Source = Take | ShowPart


@dataclass(frozen=True, slots=True, eq=False)
class Dance:
    """What D dancers dance for the seconds of a film, with `LEAD` before and after it."""

    clips: tuple[Clip, ...]
    """One for each dancer."""
    bpm: float | None
    """Tempo of the show; None for recorded takes."""
    lines: Float64
    """Times of measure lines in the film [s], ascending, (n,); empty for recorded takes."""
    steps: tuple[tuple[str, ...], ...]
    """For each dancer the step of the measure that begins at each line, (D, n)."""


def read_dance(source: Source, seconds: float, shared: Path | None, folder: Path) -> Dance | None:
    """Return `seconds` of a dance; None if its recordings are missing.

    `shared` holds the folder `mocap`; `folder` takes the file of a patch that is given as text. PersonError for a patch
    that cannot be danced; ValueError for a take that ends too early.
    """
    if isinstance(source, Take):
        return _recorded(source, seconds, shared)
    return _shown(source, seconds, folder)


def _recorded(take: Take, seconds: float, shared: Path | None) -> Dance | None:
    found = () if shared is None else recordings(shared, take.files)
    if len(found) < len(set(take.files)):
        return None
    clips = []
    for material in found:
        clip = material.clip
        if clip.seconds < take.start + seconds + 2.0 * LEAD:
            raise ValueError(
                f"{material.name}: {clip.seconds:.2f} s, too short for {take.start:g} + {seconds:g} + {2.0 * LEAD:g} s"
            )
        first = take.start * clip.sample_rate
        last = first + (seconds + 2.0 * LEAD) * clip.sample_rate
        clips.append(resample(clip, RATE, first=first, last=last))
    if take.apart:
        clips = [
            _moved(clip, np.array((x, 0.0, z)) - _middle([clip]), 0.0)
            for clip, (x, z) in zip(clips, take.apart, strict=True)
        ]
    middle = np.zeros(3) if take.apart else -_middle(clips)
    return Dance(tuple(_moved(clip, middle, take.turn_deg) for clip in clips), None, np.zeros(0), ((),) * len(clips))


def _shown(part: ShowPart, seconds: float, folder: Path) -> Dance:
    if part.patch.endswith(".toml"):
        path = PATCHES / part.patch
    else:
        path = folder / "dance.toml"
        path.write_text(part.patch, encoding="utf-8")
    loaded = load_show(path)
    show = loaded.start(seed=part.seed, tempo=part.bpm)
    library = show.graph.library
    view = show.view()
    view.detailed = True
    first, count = round(part.start / TICK), math.ceil((seconds + 2.0 * LEAD) / TICK) + 1
    dancers = np.array(part.dancers)
    places = np.zeros((count, len(dancers), 3), np.float32)
    rotations = np.zeros((count, len(dancers), SKELETON.joint_count, 4), np.float32)
    lines: list[float] = []
    steps: list[list[str]] = [[] for _ in dancers]
    for tick in range(1, first + count):
        crossed = show.tick(tick * TICK)
        if crossed and tick >= first:
            lines.append((tick - first) * TICK - LEAD)
            danced = library.node_step[show.dancers.node[dancers]]
            for own, step in zip(steps, danced.tolist(), strict=True):
                own.append(library.steps[step])
        if tick >= first:
            show.fill(view, tick * TICK)
            places[tick - first] = view.joint_position[dancers, 0]
            rotations[tick - first] = view.joint_rotation[dancers]
    clips = []
    for number in range(len(dancers)):
        local = local_rotations(rotations[:, number].astype(np.float64)).astype(np.float32)
        clips.append(
            Clip(f"dancer {number + 1}", places[:, number].copy(), local, RATE, np.zeros((count, 2), np.bool_))
        )
    middle = -_middle(clips)
    bpm = float(loaded.patch.clock.bpm if part.bpm is None else part.bpm)
    moved = tuple(_moved(clip, middle, part.turn_deg) for clip in clips)
    return Dance(moved, bpm, np.array(lines), tuple(tuple(own) for own in steps))


def _middle(clips: Sequence[Clip]) -> Float64:
    """Return the middle of the floor that the hips go over, (3,) [m], its height 0."""
    ways = np.concatenate([clip.root_position for clip in clips]).astype(np.float64)
    middle = 0.5 * (ways.min(axis=0) + ways.max(axis=0))
    return np.asarray(middle * (1.0, 0.0, 1.0))


def _moved(clip: Clip, by: Float64, turn_deg: float) -> Clip:
    """Return a clip moved `by` (3,) [m], then turned about the stage's middle; its contacts are found again."""
    turn = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(math.radians(turn_deg)))
    root = quaternion.rotate(turn, clip.root_position.astype(np.float64) + by)
    rotation = clip.rotation.astype(np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    joints, _ = forward_kinematics(root, rotation)
    contact = find_contacts(joints[:, _ANKLES], joints[:, _BALLS], clip.sample_rate)
    return replace(clip, root_position=root.astype(np.float32), rotation=rotation.astype(np.float32), contact=contact)


def crossing_patch(steps: Sequence[str], *, bpm: float, dancers: int, width: float, depth: float) -> str:
    """Return the text of a patch in which dancers change sides again and again, half of them in front of the others.

    Each is a group of its own with one of `steps` (names, in turns). They start `width` [m] apart, in two rows `depth`
    apart; in measures 3 and 4, 7 and 8 and so on those of the front go to the right and back, the others to the left.
    """
    text = [
        'name = "Crossing"', "loop_measures = 64", f"[clock]\nbpm = {bpm:g}", "[stage]\nwidth = 9.0\ndepth = 7.0",
        '[motion]\nmirror = "never"',
    ]  # fmt: skip
    for number, side in zip(range(dancers), itertools.cycle((-1.0, 1.0)), strict=False):
        step = steps[number % len(steps)]
        x = side * 0.5 * width + 0.9 * (number // 2) * side * -1.0
        text.append(
            f'[[group]]\nname = "d{number + 1}"\ndancers = 1\nsteps = ["{step}"]\ntravel_step = "walk"\n'
            f"centre = [{x:.2f}, {-side * 0.5 * depth:.2f}]\nsize = [1.0, 1.0]"
        )
        for turn, measure in enumerate(range(3, 60, 4)):
            to = width * -side * (1.0 if turn % 2 == 0 else -1.0)
            text.append(
                f'[[segment]]\nmeasure = {measure}\nmeasures = 2\ngroup = "d{number + 1}"\n'
                f'path = [[0.0, 0.0], [{to:.2f}, 0.0]]\nfacing = "linear"'
            )
    return "\n".join(text) + "\n"


Way = tuple[int, int, tuple[tuple[float, float], ...]]
"""The measure at which somebody sets out, from 1, in how many measures they arrive, and the points (x, z) [m] on their
way."""


@dataclass(frozen=True, slots=True)
class Walker:
    """A dancer who walks on ways of their own, and dances one step wherever they stay."""

    step: str
    start: tuple[float, float]
    """Where they stand at first (x, z) [m]."""
    ways: tuple[Way, ...]
    """In order, none before the one ahead of it has ended."""


def walking_patch(walkers: Sequence[Walker], *, bpm: float) -> str:
    """Return the text of a patch in which each dancer is a group of their own and walks on their ways."""
    text = [
        'name = "Walking"', "loop_measures = 64", f"[clock]\nbpm = {bpm:g}", "[stage]\nwidth = 12.0\ndepth = 8.0",
        '[motion]\nmirror = "never"',
    ]  # fmt: skip
    for number, walker in enumerate(walkers, start=1):
        x, z = walker.start
        text.append(
            f'[[group]]\nname = "d{number}"\ndancers = 1\nsteps = ["{walker.step}"]\ntravel_step = "walk"\n'
            f"centre = [{x:.2f}, {z:.2f}]\nsize = [1.0, 1.0]"
        )
        for measure, measures, points in walker.ways:
            line = ", ".join(f"[{to_x - x:.2f}, {to_z - z:.2f}]" for to_x, to_z in ((x, z), *points))
            text.append(
                f'[[segment]]\nmeasure = {measure}\nmeasures = {measures}\ngroup = "d{number}"\n'
                f'path = [{line}]\nfacing = "linear"'
            )
            x, z = points[-1]
    return "\n".join(text) + "\n"


def around(side: float, radius: float, turns: float = 1.0) -> tuple[tuple[float, float], ...]:
    """Return points (x, z) [m] round the stage's middle, `turns` times, for one of two who turn about each other.

    `side`: where they begin, -1 on the left and then behind, 1 on the right and then in front; `radius` [m].
    """
    angles = np.linspace(0.0, 2.0 * math.pi * turns, round(12 * turns) + 1)
    return tuple((side * radius * math.cos(angle), side * radius * math.sin(angle)) for angle in angles.tolist())


def heel_and_ball_contacts(clip: Clip) -> Bool:
    """Return whether heel and ball of the left and the right foot are on the floor, (T, 2, 2): samples, feet, then heel
    and ball.

    Each of the two by the same thresholds as a foot (`live.motion.foot_contact`).
    """
    joints, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    ends = [(joints[:, _ANKLES], _BALLS, _ANKLES), (joints[:, _BALLS], _ANKLES, _BALLS)]
    rest = SKELETON.rest_positions()[:, 1]
    found = []
    for points, other, own in ends:
        # the other end of the foot is given this one's place, as high over its own sole
        lifted = points.copy()
        lifted[..., 1] += rest[other] - rest[own]
        pair = (points, lifted) if own is _ANKLES else (lifted, points)
        found.append(find_contacts(*pair, clip.sample_rate))
    return np.stack(found, axis=-1)
