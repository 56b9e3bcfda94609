"""Gestures of made performers: how many of those learned from one example are found, and what following costs.

Gestures are steps of the project's library, danced between other steps by other bodies at other tempi and seen with
jitter. No real person is in it: real dancers vary in ways that are not made here.
"""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from bench._motion_clips import recordings
from live.base.arrays import Float64
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.event import ControlEvent
from live.library.step_folder import load_folder
from live.motion import quaternion
from live.motion.capture.packed_pose import pack_poses
from live.motion.clip import read_clip
from live.motion.forward_kinematics import forward_kinematics, local_rotations
from live.motion.recognition.body_stream import BodyStream
from live.motion.recognition.example_follower import ExampleFollower
from live.motion.recognition.gesture_examples import EXAMPLE_RATE, ExampleBank, GestureExample, make_examples
from live.motion.recognition.movement import Movement
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip
from live.show.capture.gesture_learning import step_features
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import DEFAULT_PATCH, PATCHES
from live.show.stages.now import Now

FPS: Final = 30.0
JITTER_M: Final = 0.04
JITTER_S: Final = 0.08
"""Root mean square of the error of a joint in space [m], and for how long it stays alike [s]."""
FILLER: Final = ("groove", "walk", "side step", "tap")
TUNED: Final = ("arm wave", "kick", "bow", "mambo")
HELD_BACK: Final = ("body roll", "reach", "jump", "samba", "turn", "grapevine")
"""Thresholds were chosen on the first ones, `FILLER` and pieces of recordings, by other bodies; these are held back."""
GROUP: Final = tuple(f"group/perfume_{name}.bvh" for name in ("aachan", "kashiyuka", "nocchi"))
LEARN_TICK: Final = 1400
TEMPO_TAKES: Final = (
    *(f"salsa/{who}.bvh" for who in ("60_05", "60_06", "60_07", "61_01", "61_05", "61_06", "61_07")), *GROUP[1:]
)  # fmt: skip
"""Takes that were not used when the tempo's constants were chosen."""
MUSIC_OFF: Final = (0.94, 1.07)
"""Tempo of the show as a share of the dancer's."""
Motion = tuple[Float64, Float64]
"""Hips (T, 3) [m] and local rotations (T, J, 4)."""
_Y: Final = np.array((0.0, 1.0, 0.0))
_BONE: Final = np.maximum(np.linalg.norm(SKELETON.offsets, axis=1), 0.14)
"""Length by which an error in space turns a joint [m]."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """With `full` examples of four bodies, otherwise of one."""
    clips: dict[str, StepClip] = {}
    for clip in load_folder(PATCHES / "steps"):
        if not clip.mirrored:
            clips.setdefault(clip.step, clip)
    rows: list[Row] = []
    for words, names, seeds, first in (("held back", HELD_BACK, (11, 12, 13, 14), 77), ("tuned", TUNED, (1, 2, 3), 50)):
        streams = [_stream(clips, names, seed) for seed in seeds]
        for shots, kind, left_out in (
            (1, "one example", ()), (1, "one example, library without these steps", (*names, *FILLER)),
            (1, "one example, no library", tuple(clips)), (3, "three examples", ()),
        ):  # fmt: skip
            library = [step_features(clip) for name, clip in clips.items() if name not in left_out]
            found = np.zeros(3, np.int64)
            for body in range(first, first + (4 if full else 1)):
                found += _found(clips, names, streams, library, body, shots)
            bar = 0.9 if kind == "one example" and words == "held back" else None
            note = f"right {found[0]}, false alarms {found[1]}, missed {found[2]}; made dancers"
            f1 = 2.0 * found[0] / max(2 * found[0] + found[1] + found[2], 1)
            rows.append(Row(f"F1 of own gestures from {kind}, {words}", float(f1), "of 1", bar, "at least", note=note))
    return rows + _recorded(shared) + _tempo(shared) + _costs()


def _danced(clip: StepClip, chance: np.random.Generator, style: tuple[Float64, Float64], tempo: float) -> Motion:
    """Return a step danced by a body of this style (size of its motion and offsets of its joints), uneven in time."""
    count = clip.samples_per_measure * clip.measures
    part = np.linspace(0.0, 1.0, int(count / clip.clip.sample_rate / tempo * FPS))
    part = np.clip(part + chance.uniform(-0.05, 0.05) * np.sin(2.0 * np.pi * part), 0.0, 1.0)
    root, rotation, _ = read_clip(clip.clip, clip.first + part * count)
    amount, offset = style
    for joint in range(1, JOINT_COUNT):
        vector = quaternion.to_rotation_vector(quaternion.align_signs(rotation[:, joint]))
        mean = vector.mean(axis=0)
        turned = (vector - mean) * amount[joint] + mean + offset[joint]
        rotation[:, joint] = quaternion.from_rotation_vector(turned)
    return np.asarray(root, np.float64), np.asarray(rotation, np.float64)


def _style(chance: np.random.Generator) -> tuple[Float64, Float64]:
    return 1.0 + chance.uniform(-0.18, 0.2, JOINT_COUNT), chance.normal(0.0, 0.08, (JOINT_COUNT, 3))


Stream = tuple[Float64, list[tuple[str, float, float]]]
"""Features (M, F) of a motion, and when each step began and ended [s]."""


def _stream(clips: dict[str, StepClip], names: Sequence[str], seed: int) -> Stream:
    """Return each gesture three times between other steps, on a stage, with jitter."""
    chance = np.random.default_rng(seed)
    style, yaw, place = _style(chance), chance.uniform(-np.pi, np.pi), np.zeros(3)
    steps: list[str] = []
    for number in range(3 * len(names)):
        steps += [str(each) for each in chance.choice(FILLER, chance.integers(1, 3))]
        steps.append(names[number % len(names)])
    roots, rotations, danced, count = [], list[Float64](), [], 0
    for step in [*steps, FILLER[0]]:
        root, rotation = _danced(clips[step], chance, style, chance.uniform(0.75, 1.3))
        turn = quaternion.from_axis_angle(_Y, np.asarray(yaw))
        root = quaternion.rotate(turn, root - root[0] * (1.0, 0.0, 1.0)) + place
        rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
        if rotations:
            share = (np.arange(8) + 1.0) / 9.0
            rotation[:8] = quaternion.slerp(rotations[-1][-1][None], rotation[:8], share[:, None])
        danced.append((step, count / FPS, (count + len(root)) / FPS))
        count += len(root)
        roots.append(root)
        rotations.append(rotation)
        place, yaw = root[-1] * (1.0, 0.0, 1.0), yaw + chance.uniform(-0.4, 0.4)
    return _features(*_seen(np.concatenate(roots), np.concatenate(rotations), chance)), danced


def _seen(root: Float64, rotation: Float64, chance: np.random.Generator) -> Motion:
    """Return a motion with errors as of a camera."""
    keep = np.exp(-1.0 / (FPS * JITTER_S))
    errors = chance.standard_normal((len(root), JOINT_COUNT + 1, 3))
    for row in range(1, len(errors)):
        errors[row] = keep * errors[row - 1] + np.sqrt(1.0 - keep * keep) * errors[row]
    errors *= JITTER_M / np.sqrt(3.0)
    _, world = forward_kinematics(root, rotation)
    turned = quaternion.from_rotation_vector(errors[:, 1:] * (np.sqrt(2.0) / _BONE[:, None]))
    return root + errors[:, 0], np.asarray(local_rotations(quaternion.mul(turned, world)), np.float64)


def _features(root: Float64, rotation: Float64) -> Float64:
    stream, rows = BodyStream(), []
    hips, turned = root.astype(np.float32), rotation.astype(np.float32)
    for row in range(len(hips)):
        for _ in stream.feed(hips[row], turned[row], 1.0 + row / FPS):
            if stream.count % 2 == 0:
                rows.append(stream.feature.copy())
    return np.array(rows)


def _told(examples: list[GestureExample], gesture: list[int], motion: Float64) -> list[tuple[int, float]]:
    """Return the gestures that are told in a motion, and when [s]."""
    follower = ExampleFollower(ExampleBank.of(examples), gesture)
    return [(made, (row + 1) / EXAMPLE_RATE) for row, feature in enumerate(motion) for made in follower.step(feature)]


def _found(
    clips: dict[str, StepClip], names: Sequence[str], streams: list[Stream], library: list[Float64], body: int,
    shots: int,
) -> np.ndarray[tuple[int], np.dtype[np.int64]]:  # fmt: skip
    """Return how many gestures are told, told falsely, and missed; examples are danced by `body` without jitter."""
    examples: list[GestureExample] = []
    gesture: list[int] = []
    for number, name in enumerate(names):
        takes = []
        for shot in range(shots):
            chance = np.random.default_rng([body, shot])
            takes.append(_features(*_danced(clips[name], chance, _style(chance), chance.uniform(0.85, 1.15))))
        made = make_examples(takes, [], library)
        examples += made
        gesture += [number] * len(made)
    found = np.zeros(3, np.int64)
    for motion, danced in streams:
        told = _told(examples, gesture, motion)
        for number, name in enumerate(names):
            open_spans = [(begin + 0.4 * (end - begin), end + 0.8) for step, begin, end in danced if step == name]
            for made_number, at in told:
                if made_number != number:
                    continue
                span = next((one for one in open_spans if one[0] <= at <= one[1]), None)
                found += (1, 0, 0) if span else (0, 1, 0)
                if span:
                    open_spans.remove(span)
            found[2] += len(open_spans)
    return found


def _recorded(shared: Path | None) -> list[Row]:
    """Two-second gestures of one of three dancers of a choreography, looked for in the others' motion."""
    name = "examples of one recorded dancer that are told in the others' motion at the same time"
    takes = recordings(shared or Path(__file__).resolve().parents[2] / "shared", GROUP)
    if len(takes) < len(GROUP):
        return [Row(name, None, "of all", note="no recordings here (--shared)")]
    motions = []
    for take in takes:
        clip = take.clip
        at = np.arange(int(clip.seconds * FPS) - 1) * clip.sample_rate / FPS
        root, rotation, _ = read_clip(clip, at)
        motions.append(_features(np.asarray(root, np.float64), np.asarray(rotation, np.float64)))
    right = total = others = 0
    moments = round(2.0 * EXAMPLE_RATE)
    for first in range(0, len(motions[0]) - moments, 5 * moments):
        examples = make_examples([motions[0][first : first + moments]])
        end = (first + moments) / EXAMPLE_RATE
        for motion in motions[1:]:
            told = [at for _, at in _told(examples, [0], motion)]
            right += any(abs(at - end) < 1.0 for at in told)
            others += sum(abs(at - end) >= 1.0 for at in told)
            total += 1
    note = f"{total} pairs; {others} told at other times, where the choreography may repeat; not tuned on"
    return [Row(name, right / max(total, 1), "of all", note=note)]


def _tempo(shared: Path | None) -> list[Row]:
    """Tempo of recorded dancers seen with jitter, against that of the whole take, every half second from the fourth."""
    names = ("tempo of recorded dancers within 3 %", "the same, of the times at which one is told")
    takes = recordings(shared or Path(__file__).resolve().parents[2] / "shared", TEMPO_TAKES)
    if not takes:
        return [Row(name, None, "of all", note="no recordings here (--shared)") for name in names]
    told: list[float] = []
    for number, take in enumerate(takes):
        bpm = 240.0 * take.clip.sample_rate / take.steps[0].samples_per_measure
        at = np.arange(int(take.clip.seconds * FPS) - 1) * take.clip.sample_rate / FPS
        root, rotation, _ = read_clip(take.clip, at)
        chance = np.random.default_rng([6, number])
        hips, turned = _seen(np.asarray(root, np.float64), np.asarray(rotation, np.float64), chance)
        for off in MUSIC_OFF:
            stream, movement = BodyStream(), Movement()
            for row in range(len(hips)):
                for _ in stream.feed(hips[row].astype(np.float32), turned[row].astype(np.float32), 1.0 + row / FPS):
                    movement.follow(stream.measure, off * bpm)
                    if stream.count % 16 == 0 and stream.count >= 128:
                        told.append(movement.tempo / bpm)
    shares = np.array(told)
    right, known = np.abs(shares - 1.0) <= 0.03, shares > 0.0
    note = (
        f"{len(takes)} takes, not tuned on; the tempo of a whole take is estimated too; music 6 % slower or 7 % faster"
    )
    return [
        Row(names[0], float(right.mean()), "of all", note=note),
        Row(names[1], float(right[known].mean()), "of told", note=f"told in {known.mean():.2f} of all"),
    ]


def _costs() -> list[Row]:
    """One performer, four known gestures and four with examples; then an example of 16 beats is learned."""
    loaded = load_show(DEFAULT_PATCH)
    clip = next(clip for clip in loaded.graph.library.clips if not clip.mirrored)
    samples = clip.first + np.arange(2400) * TICK * clip.clip.sample_rate % (clip.samples_per_measure * clip.measures)
    root, rotation, _ = read_clip(clip.clip, samples)
    poses = pack_poses(root, rotation)
    known = [{"name": f"known {name}", "movement": name} for name in ("both arms up", "jump", "clap", "turn")]
    own = [{"name": f"own {number}", "poses": poses[number : 128 + number : 4]} for number in range(4)]
    fields = loaded.patch.model_dump(exclude_unset=True)
    patch = Patch.model_validate(fields | {"mocap": [{"name": "anna"}], "gesture": [*known, *own]})
    show = LoadedShow(loaded.path, patch, loaded.graph).start()
    gestures, costs = show.gestures, {False: list[float](), True: list[float]()}
    follow = gestures.tick

    def timed(now: Now) -> list[ControlEvent]:
        learning, begin = bool(gestures.facts()["learning"]), time.thread_time()
        told = follow(now)
        costs[learning].append(1e6 * (time.thread_time() - begin))
        return told

    setattr(gestures, "tick", timed)  # noqa: B010 - a method
    for tick in range(1, len(poses)):
        at = tick * TICK
        if tick % 2:
            show.apply(events.MocapFrame(time=at - 0.004, source="vmc", performer="anna", pose=poses[tick]))
        if tick == LEARN_TICK:
            show.apply(events.LearnGesture(time=at, source="osc", name="new", beats=16.0))
        show.tick(at)
    note = "one performer, four known gestures, four with examples; ticks with a new pose"
    return [
        Row(
            "gestures followed in a tick, CPU, median",
            float(np.median(costs[False][100:LEARN_TICK:2])),
            "us",
            100.0,
            note=note,
        ),
        Row("the same while 16 beats are learned, CPU, median", float(np.median(costs[True])), "us", 300.0),
        Row("the same while 16 beats are learned, CPU, 95 %", float(np.percentile(costs[True], 95)), "us"),
        Row("ticks until it can be found", float(len(costs[True])), "ticks"),
    ]
