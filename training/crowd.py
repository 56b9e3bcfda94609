"""Makes items without music, in which nobody could name a beat: `python -m training.crowd DIR --count N --seed S`.

A crowd that talks, applause, noise, hum, in a room or not: the network should say nothing.
"""

import argparse
import json
from pathlib import Path
from random import Random

import numpy as np
import soundfile

from training.rendering import level, noise, room
from training.rendering.synth import RATE, Mono


def crowd(rng: Random, seconds: float) -> Mono:
    """One or two sorts of noise, coming and going, with some level."""
    draw, count = np.random.default_rng(rng.getrandbits(64)), int(seconds * RATE)
    makers = [noise.babble, noise.babble, noise.applause, noise.applause, noise.pink]
    sound = np.zeros(count, np.float32)
    for _ in range(rng.choice([1, 1, 2])):
        made = rng.choice(makers)(draw, count)
        knots = max(4, int(seconds / rng.uniform(2.0, 12.0)))
        swell = np.interp(np.linspace(0, knots - 1, count), np.arange(knots), draw.uniform(0.3, 1.0, knots))
        sound += (made / (np.std(made) + 1e-9) * swell * rng.uniform(0.3, 1.0)).astype(np.float32)
    if rng.random() < 0.6:
        sound = room.room(draw, sound, rng.choice([0.4, 0.8, 1.5, 2.5]), rng.uniform(-6, 10))
    if rng.random() < 0.3:
        sound = room.tilt(draw, sound)
    if rng.random() < 0.15:
        sound = room.hum(draw, sound)
    return level.normal(level.high_pass(sound), 10 ** (-rng.uniform(0, 35) / 20))


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m training.crowd", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=45.0)
    wanted = parser.parse_args()
    wanted.folder.mkdir(parents=True, exist_ok=True)
    for index in range(wanted.count):
        stem = wanted.folder / f"{index:05d}"
        sound = crowd(Random(f"crowd/{wanted.seed}/{index}"), wanted.seconds)
        soundfile.write(stem.with_suffix(".wav"), sound, RATE, subtype="PCM_16")
        stem.with_suffix(".beats").write_text("")
        facts = {"style": "crowd alone", "family": "crowd", "split": "train", "ignore": [], "has_downbeat": False}
        stem.with_suffix(".json").write_text(json.dumps(facts, indent=1) + "\n")


if __name__ == "__main__":
    main()
