"""Waltzes fast and slow, musette, mazurka, minuet, ländler: three in all its walks."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Oompah, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Shadow
from training.music.harmony import CLASSICAL, CLASSICAL_MINOR, MINOR, POP, Key, key
from training.music.melody import Melody
from training.music.piece import THREE
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony


def old_key(rng: Random) -> tuple[Key, list[str]]:
    """A key with classical progressions."""
    found = key(rng, "major", "major", "harmonic")
    return found, CLASSICAL if found.scale == "major" else CLASSICAL_MINOR


@style("waltz", "waltz", 1.6)
def waltz(rng: Random) -> Plan:
    """Oom-pah-pah under a melody: ballroom, musette, fairground, orchestra."""
    found, lines = old_key(rng)
    group = rng.choice(
        [
            ("strings", "pizzicato", "strings"),
            ("accordion", "accordion", "accordion"),
            ("piano", "piano", "piano"),
            ("reeds", "tuba", "solo brass"),
            ("organ", "organ", "organ"),
            ("music box", "harp", "bells"),
            ("nylon", "upright", "violin"),
        ]
    )
    melody = Melody(rng, 60, 86, rng.uniform(0.2, 0.7), 0.03, pickup=0.55)
    seats = [
        Seat("comp", Oompah(rng, rng.randint(56, 64), bass=False, dry=rng.uniform(0.3, 0.9)), program(rng, group[0])),
        Seat("bass", Oompah(rng, low=rng.choice([34, 38, 43]), chords=False), program(rng, group[1])),
        Seat("lead", melody, program(rng, group[2], "violin", "flutes", "reeds")),
    ]
    if rng.random() < 0.3:
        seats.append(Seat("second", Shadow(melody), program(rng, "strings", "reeds", "accordion")))
    if rng.random() < 0.3:
        groove = Groove({"kick": "X...........", rng.choice(["snare", "hat", "rim"]): "....x...x..."})
        seats.append(
            Seat("drums", Drummer(rng, groove, crash=0.2, fills=0.3), kit(rng, "standard", "brush", "orchestra"))
        )
    return Plan(
        rng.triangular(84, 196, 150),
        seats,
        harmony(rng, found, [*lines, *POP[:4]] if found.scale == "major" else lines),
        found,
        THREE,
        timing=rng.choice(["human", "human", "expressive"]),
        drift=rng.uniform(0.01, 0.05),
    )


@style("pop in three", "waltz", 1.5)
def pop_three(rng: Random) -> Plan:
    """Songs in three with a small kit, guitar or piano; snare on three or on two and three, brushes; slow or quick."""
    found = key(rng, "major", "minor", "mixolydian")
    lanes = {
        "kick": rng.choice(["X...........", "X.....x.....", "X..........x"]),
        rng.choice(["snare", "rim", "clap"]): rng.choice(
            ["....x...X...", "........X...", "....X...X...", "....X......."]
        ),
    }
    lanes[rng.choice(["hat", "ride", "shaker", "tamb"])] = rng.choice(["x.x.x.x.x.x.", "x...x...x...", "xoxoxoxoxoxo"])
    seats = [
        Seat(
            "bass",
            Bass(rng, ["X.....", "X...x.", "X.x.x.", "X..x.."], rng.choice(["root", "fifth"])),
            program(rng, "bass", "upright", "synth bass"),
        ),
        Seat(
            "comp",
            either(
                rng,
                Comp(rng, ["X.x.x.", "..x.x.", "xxxxxx", "X.xxxx"], 60, 4, 0.7),
                Arpeggio(rng, 2, voices=4),
                Arpeggio(rng, 4, voices=3),
            ),
            program(rng, "piano", "steel", "nylon", "epiano"),
        ),
        Seat(
            "lead",
            Melody(rng, 60, 82, 0.45, 0.12, pickup=0.5),
            program(rng, "choir", "flutes", "reeds", "lead", "violin", "solo brass"),
        ),
    ]
    if rng.random() < 0.75:
        seats.append(Seat("drums", Drummer(rng, Groove(lanes)), kit(rng, "standard", "room", "brush", "808")))
    if rng.random() < 0.4:
        seats.append(Seat("pad", Pad(rng), program(rng, "strings", "pad", "organ"), 0.7))
    return Plan(
        rng.triangular(72, 180, 108),
        seats,
        harmony(rng, found, MINOR if found.scale == "minor" else POP),
        found,
        THREE,
        timing=rng.choice(["human", "machine"]),
        swing=rng.choice([0.5, 0.5, 0.6]),
    )


@style("minuet", "waltz", 0.9)
def minuet(rng: Random) -> Plan:
    """Two hands or strings: quarter notes in the bass, eighths above, phrases of four and eight."""
    found, lines = old_key(rng)
    instrument = program(rng, "harpsichord", "piano", "strings", "flutes", "nylon", "organ")
    seats = [
        Seat(
            "bass",
            Bass(rng, ["X.x.x.", "X...x.", "X.....", "X.x.X."], rng.choice(["arpeggio", "scale", "root"]), 43, 0.85),
            instrument,
        ),
        Seat(
            "lead",
            Melody(rng, 64, 86, rng.uniform(0.5, 0.8), 0.02, 0.04, 0.25),
            instrument if rng.random() < 0.6 else program(rng, "violin", "flutes", "reeds"),
        ),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("comp", Oompah(rng, 60, bass=False), instrument, 0.7))
    return Plan(
        rng.uniform(88, 144),
        seats,
        harmony(rng, found, lines),
        found,
        THREE,
        timing=rng.choice(["human", "expressive"]),
        drift=rng.uniform(0.015, 0.05),
        lengths=(8, 8, 16),
    )


@style("mazurka", "waltz", 0.7, held_out=True)
def mazurka(rng: Random) -> Plan:
    """The accent goes to two or three; dotted first beats; much rubato."""
    found, lines = old_key(rng)
    piano = program(rng, "piano", "accordion", wild=0.02)
    given = rng.choice(
        [
            [(0.0, 0.8), (0.75, 0.5), (1.0, 1.0), (2.0, 0.8)],
            [(0.0, 0.8), (2 / 3, 0.5), (1.0, 0.9), (2.0, 0.7)],
            [(0.0, 0.7), (0.5, 0.7), (1.0, 1.0)],
            [(0.0, 0.8), (1.0, 0.8), (2.0, 0.8)],
        ]
    )
    seats = [
        Seat("comp", Oompah(rng, 58, 40), piano),
        Seat("lead", Melody(rng, 64, 86, 0.5, 0.05, pickup=0.3, given=given if rng.random() < 0.6 else None), piano),
    ]
    return Plan(
        rng.uniform(104, 168),
        seats,
        harmony(rng, found, lines),
        found,
        THREE,
        timing="expressive",
        drift=rng.uniform(0.05, 0.14),
    )
