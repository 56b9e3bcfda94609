"""Makes a set of training items: `python -m training.dataset DIR --count N --seed S`."""

import argparse
import hashlib
import json
import sys
import wave
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from random import Random

import numpy as np

import training.music.styles  # noqa: F401 (registers the styles)
from training.music.piece import Piece, Sounding
from training.music.registry import STYLES, Style, compose
from training.rendering.damage import Take, spoil
from training.rendering.drum_machine import play
from training.rendering.synth import FONTS, RATE, Mono, available, fonts, synthesise
from training.rendering.tone import tone

SPLITS = ("train", "validation", "held-out")


def choose(rng: Random, split: str, families: tuple[str, ...] = ()) -> Style:
    """A style (of these families or names) by weight: held-out ones only in `held-out`; a third in `validation`."""
    held = split == "held-out" or (split == "validation" and rng.random() < 0.33)
    pool = [STYLES[name] for name in sorted(STYLES) if STYLES[name].held_out == held]
    if families:
        pool = [style for style in pool if style.family in families or style.name in families]
    return rng.choices(pool, [style.weight for style in pool])[0]


def take_of(rng: Random, piece: Piece, seconds: float, font: str) -> Take:
    """A piece performed, synthesised and cut: from its very beginning (with some silence before) or from anywhere."""
    notes, fewer = _fewer(rng, piece, piece.perform(rng))
    beats = piece.beats()
    bar = beats[piece.metre.beats][0] - beats[0][0]
    if rng.random() < 0.25:
        start = -rng.uniform(0.02, 1.5) if rng.random() < 0.7 else -rng.uniform(1.5, 6.0)
    else:
        start = rng.uniform(0, max(0.1, min(6 * bar, beats[-1][0] - seconds - 1)))
    lead = max(0.0, -start)
    notes = [note._replace(time=note.time - start) for note in notes if note.time - start < seconds]
    early = [note for note in notes if note.time < 0]
    hang = max([0.0, *(-note.time for note in early)])
    hang = min(hang, 4.0)  # what sounded before the cut is heard dying away
    notes = [note._replace(time=note.time + hang) for note in notes if note.time >= -hang]
    sound = _sound(rng, piece, notes, font, seconds + hang)[int(hang * RATE) :]
    kept = [(time - start, place) for time, place in beats if -1e-9 <= time - start < seconds]
    ignore = [(a - start, b - start) for a, b in piece.clock.silences() if a - start < seconds and b - start > 0]
    for a, b in piece.mutes:
        begin, end = (float(time) - start for time in piece.clock.seconds([a, b]))
        if end > 0 and begin < seconds and end - begin > 3.0:
            ignore.append((begin + 2.0, end))
    ignore += _silences(notes, hang, min(seconds, beats[-1][0] - start))
    take = Take(sound, kept, ignore)
    if lead > 0.8:
        take.done.append("starts after silence")
    if fewer:
        take.done.append(fewer)
    return take


def _fewer(rng: Random, piece: Piece, notes: list[Sounding]) -> tuple[list[Sounding], str]:
    """The notes, of some pieces without those of the drums, of some with those alone; and what was left out.

    The beats stay the same. Pieces of drummers keep their drums; nobody is left who plays too little to tell a beat.
    """
    draw = rng.random()
    drums = _drums(piece)
    if draw >= 0.2 or STYLES[piece.style].family in ("drums", "hand drums"):
        return notes, ""
    kept = [note for note in notes if (note.channel in drums) == (draw >= 0.15)]
    onsets = len({round(note.time, 1) for note in kept})
    if len(kept) == len(notes) or onsets < 0.8 * len(piece.beats()):
        return notes, ""
    return kept, "without drums" if draw < 0.15 else "drums alone"


def _drums(piece: Piece) -> set[int]:
    """The channels of kits and of tuned drums."""
    return {channel for channel, program in piece.programs() if channel == 9 or 115 <= program <= 118}


def _sound(rng: Random, piece: Piece, notes: list[Sounding], font: str, seconds: float) -> Mono:
    """The notes through a font with a drawn mix; the drums sometimes through a drum machine of our own."""
    programs = piece.programs()
    controls = tone(rng, [channel for channel, _ in programs])
    drums = _drums(piece)
    if not drums or rng.random() > 0.22:
        return synthesise(notes, programs, fonts()[font], seconds, controls)
    ours = play(rng, [note for note in notes if note.channel in drums], seconds)
    rest = [note for note in notes if note.channel not in drums]
    if not rest:
        return ours
    return ours + synthesise(rest, programs, fonts()[font], seconds, controls)


def _silences(notes: list[Sounding], hang: float, seconds: float) -> list[tuple[float, float]]:
    """Spans in which nobody has played for two seconds, or in which nobody has begun a note for six."""
    found = []
    onset, end = -hang, -hang
    for note in [*notes, Sounding(seconds + hang, 0.0, 0, 0, 0)]:
        start = min(max(end + 2.0, onset + 2.0), onset + 6.0)
        if note.time > start and onset > -hang:
            found.append((start - hang, note.time - hang))
        onset, end = note.time, max(end, note.time + note.duration)
    return found


def make(
    split: str, seed: int, index: int, seconds: float, families: tuple[str, ...] = ()
) -> tuple[Mono, list[tuple[float, int]], dict[str, object]]:
    """One item: sound, beats, and what is known about it. The same arguments give the same item."""
    rng = Random(f"{split}/{seed}/{index}")
    style = choose(rng, split, families)
    have = fonts()
    names = [name for name in FONTS if name in have]
    font = rng.choices(names, [FONTS[name] for name in names])[0]
    piece = compose(rng, style.name, seconds + 8)
    take = take_of(rng, piece, seconds, font)
    known = piece.has_downbeat
    if rng.random() < 0.1:  # a medley: another piece takes over, on the spot
        other = choose(rng, split, families)
        after = compose(rng, other.name, seconds + 8)
        take = _medley(rng, take, take_of(rng, after, seconds, font), seconds)
        known = known and after.has_downbeat
        take.done.append(f"then {other.name}")
    take = spoil(rng, take)
    facts: dict[str, object] = {
        "style": style.name, "family": style.family, "split": split, "held_out": style.held_out, "font": font,
        "metre": piece.metre.name, "beats_per_bar": piece.metre.beats, "bpm": round(piece.bpm, 2),
        "has_downbeat": known, "ignore": [[round(a, 4), round(b, 4)] for a, b in sorted(take.ignore)],
        "done": take.done, "seed": seed, "index": index, "seconds": round(len(take.sound) / RATE, 3),
    }  # fmt: skip
    end = len(take.sound) / RATE
    return take.sound, [beat for beat in take.beats if beat[0] < end], facts


def _medley(rng: Random, first: Take, second: Take, seconds: float) -> Take:
    """The first until somewhere in the middle, then the second; cut hard, or with a crossfade of up to a second."""
    cut = rng.uniform(0.3, 0.7) * seconds
    cross = rng.choice([0.01, 0.01, 0.3, 1.0])
    times = np.arange(len(first.sound)) / RATE
    share = np.clip((times - cut) / cross, 0, 1)
    late = np.zeros(len(first.sound), np.float32)
    at = int(cut * RATE)
    late[at:] = second.sound[: len(late) - at]
    sound = first.sound * np.sqrt(1 - share) + late * np.sqrt(share)
    beats = [beat for beat in first.beats if beat[0] < cut - 0.02]
    beats += [(time + cut, place) for time, place in second.beats if time + cut < seconds and time > 0.02]
    ignore = [(a, min(b, cut)) for a, b in first.ignore if a < cut]
    ignore += [(a + cut, b + cut) for a, b in second.ignore]
    return Take(np.asarray(sound, np.float32), beats, ignore, [*first.done, *second.done])


def write(folder: Path, index: int, split: str, seed: int, seconds: float, families: tuple[str, ...] = ()) -> str:
    """Makes and writes one item: NNNNN.wav, NNNNN.beats, NNNNN.json. Returns its style."""
    sound, beats, facts = make(split, seed, index, seconds, families)
    stem = folder / f"{index:05d}"
    data = np.clip(np.round(sound * 32767), -32768, 32767).astype("<i2").tobytes()
    with wave.open(str(stem.with_suffix(".wav")), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(data)
    stem.with_suffix(".beats").write_text("".join(f"{time:.5f}\t{place}\n" for time, place in beats))
    facts["sha256"] = hashlib.sha256(data).hexdigest()
    stem.with_suffix(".json").write_text(json.dumps(facts, indent=1) + "\n")
    return str(facts["style"])


def main(arguments: list[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m training.dataset", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="number of the first item")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=45.0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--split", choices=SPLITS, default="train")
    parser.add_argument("--families", nargs="*", default=[], help="only styles of these families, or with these names")
    wanted = parser.parse_args(arguments)
    reason = available()
    if reason is not None:
        print(f"Nothing can be rendered: {reason}", file=sys.stderr)
        return 2
    wanted.folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(wanted.jobs) as pool:
        jobs = [
            pool.submit(write, wanted.folder, index, wanted.split, wanted.seed, wanted.seconds, tuple(wanted.families))
            for index in range(wanted.first, wanted.first + wanted.count)
        ]
        for done, job in enumerate(as_completed(jobs), 1):
            style = job.result()
            if done % 20 == 0 or done == wanted.count:
                print(f"{done}/{wanted.count} {style}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
