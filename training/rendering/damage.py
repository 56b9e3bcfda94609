"""What becomes of music before it is heard: a draw of media, rooms, crowds, levels and silences for one item."""

from dataclasses import dataclass, field
from random import Random

import numpy as np

from training.rendering import level, medium, noise, room
from training.rendering.synth import RATE, Mono


@dataclass(slots=True)
class Take:
    """Sound with its beats (seconds, place in the bar), spans to ignore, and what was done to it."""

    sound: Mono
    beats: list[tuple[float, int]]
    ignore: list[tuple[float, float]]
    done: list[str] = field(default_factory=list)


def spoil(rng: Random, take: Take, share: float = 0.4) -> Take:
    """Damages this share of the takes, each in one to four ways; all get some level."""
    draw = np.random.default_rng(rng.getrandbits(64))
    if rng.random() < share:
        _time(rng, draw, take)
        _space(rng, draw, take)
        _company(rng, draw, take)
        _gaps(rng, take)
    elif rng.random() < 0.5:
        take.sound = room.room(draw, take.sound, rng.uniform(0.25, 0.9), rng.uniform(4, 16))
        take.done.append("ambience")
    if rng.random() < 0.35:
        take.sound = level.compress(draw, level.normal(take.sound, 1.0))
        take.done.append("compressed")
    if rng.random() < 0.15:
        take.sound = level.limit(draw, take.sound)
        take.done.append("limited")
    if rng.random() < 0.05:
        take.sound = level.sampler(draw, take.sound)
        take.done.append("sampler")
    loud = -rng.uniform(0, 12) if rng.random() < 0.7 else -rng.uniform(0, 35)
    take.sound = level.high_pass(take.sound)
    if rng.random() < 0.04:
        take.sound = level.clip(draw, take.sound)
        take.done.append("clipped")
    take.sound = level.normal(take.sound, 10 ** (loud / 20))
    return take


def _time(rng: Random, draw: np.random.Generator, take: Take) -> None:
    chance = rng.random()
    if chance > 0.2:
        return
    seconds = len(take.sound) / RATE
    warp = medium.wow(draw, seconds) if chance < 0.12 else medium.fader(draw, seconds)
    take.sound = warp.play(take.sound)
    times = warp.at(np.array([time for time, _ in take.beats]))
    take.beats = [(float(time), place) for time, (_, place) in zip(times, take.beats, strict=True)]
    take.ignore = [(float(a), float(b)) for a, b in (warp.at(np.array(span)) for span in take.ignore)]
    if chance < 0.12:
        take.sound = noise.add(take.sound, noise.crackle(draw, len(take.sound)), rng.uniform(12, 35))
    take.done.append("wow" if chance < 0.12 else "fader")


def _space(rng: Random, draw: np.random.Generator, take: Take) -> None:
    if rng.random() < 0.55:
        take.sound = room.room(
            draw,
            take.sound,
            rng.choice([0.3, 0.5, 0.8, 1.2, 1.8, 2.5, 3.2]) * rng.uniform(0.8, 1.2),
            rng.uniform(-8, 10),
        )
        take.done.append("room")
    chance = rng.random()
    if chance < 0.35:
        take.sound = room.tilt(draw, take.sound)
        take.done.append("tilt")
    elif chance < 0.5:
        take.sound = room.phone(draw, take.sound)
        take.done.append("phone")
    elif chance < 0.58:
        take.sound = room.muffled(draw, take.sound)
        take.done.append("muffled")


def _company(rng: Random, draw: np.random.Generator, take: Take) -> None:
    count = len(take.sound)
    chance = rng.random()
    if chance < 0.55:
        kind = rng.choice(["babble", "babble", "pink", "applause", "both"])
        made = (
            noise.pink(draw, count)
            if kind == "pink"
            else noise.applause(draw, count)
            if kind == "applause"
            else noise.babble(draw, count)
        )
        if kind == "both":
            other = noise.applause(draw, count)
            share = rng.uniform(0.2, 1.0)
            made = np.asarray(made / (np.std(made) + 1e-9) + share * other / (np.std(other) + 1e-9), np.float32)
        loud = rng.random() < 0.3  # a crowd as loud as the music, or nearly
        take.sound = noise.add(take.sound, made, rng.uniform(0, 10) if loud else rng.uniform(4, 30))
        take.done.append(f"loud {kind}" if loud else kind)
    if rng.random() < 0.1:
        take.sound = room.hum(draw, take.sound)
        take.done.append("hum")


def _gaps(rng: Random, take: Take) -> None:
    """Fades, and silences through which the beats go on (to be ignored after the first second)."""
    seconds = len(take.sound) / RATE
    chance = rng.random()
    if chance < 0.06:
        end = rng.uniform(0.5, 1.0) * seconds
        take.sound = level.fade(take.sound, end - rng.uniform(3, 10), end)
        take.ignore.append((end - 1.0, seconds))
        take.beats = [beat for beat in take.beats if beat[0] < end]
        take.done.append("fade out")
    elif chance < 0.12:
        take.sound = level.fade(take.sound, rng.uniform(2, 10), -0.5)
        take.ignore.append((0.0, 0.7))
        take.done.append("fade in")
    elif chance < 0.22:
        start, length = rng.uniform(4, seconds - 9), rng.uniform(1, 8)
        take.sound = take.sound.copy()
        take.sound[int(start * RATE) : int((start + length) * RATE)] *= 0.0
        take.ignore.append((start, start + length))
        take.done.append("silence")
