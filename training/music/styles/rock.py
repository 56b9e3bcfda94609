"""Rock and pop bands: backbeat, half time, double time, punk, shuffle, ballads, in four and in three."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Player, Seat, Varied
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Figure, Shadow
from training.music.form import Compose, song
from training.music.harmony import MINOR, POP, ROCK, Key, key, progression
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.piece import COMMON
from training.music.programs import kit, program
from training.music.registry import style

HATS = [
    "x.x.x.x.x.x.x.x.",
    "X.o.X.o.X.o.X.o.",
    "xoxoxoxoxoxoxoxo",
    "X...X...X...X...",
    "x.x.x.xxx.x.x.x.",
    "oxoxoxoxoxoxoxox",
]
KICKS = [
    "X.......X.......",
    "X.....x.X.......",
    "X.......X.x.....",
    "X.x.....X.x.....",
    "X......xX.......",
    "X..x....X..x....",
    "X.....x.x.......",
    "X.......x..x....",
    "X.....xx..x.....",
    "X...x.x.X.......",
    "X..x..x...x..x..",
    "X.........x.....",
    "X.x...x.X.x...x.",
    "X..x..x.x.......",
    "X.......x.x...x.",
]
SNARES = [
    "....X.......X...",
    "....X.......X...",
    "....X.......X...",
    "....X.......X..o",
    "....X..-.-..X...",
    "....X..-....X.-.",
]
DRIVE = ["xxxxxxxx", "X.x.X.x.", "X...X...", "X..xX.x.", "X..x..x.", "X.xxX.xx", "X.....xx", "X...x..x"]
GUITAR = [
    "x.x.x.x.",
    "X.xxX.xx",
    "X..x..x.",
    "X.......",
    "..X...X.",
    "XxxxXxxx",
    "X..xx.x.",
    "X.xx.xxx",
    "..x...x.",
    "X...X...",
]
STRUM = [
    "X.x.xxx.",
    "X.xx.xx.",
    "X.x.X.xx",
    "X..x.xx.",
    "XxxxXxxx",
    "x.o.x.o.x.o.x.oo",
    "X...X.oo..oox.oo",
    "X.xoXoxoX.xoXoxo",
]


def harmony(rng: Random, key: Key, lines: list[str], split: float = 0.05) -> Compose:
    """A harmony for each label from these lines; sections differ mostly."""
    first = rng.choice(lines)
    return lambda label, bars: progression(rng, key, [first] if rng.random() < 0.35 else lines, bars, split)


def rock_harmony(rng: Random) -> tuple[Key, Compose]:
    """Key and harmony of a rock song."""
    if rng.random() < 0.45:
        found = key(rng, "minor", "dorian", "minor pentatonic")
        return found, harmony(rng, found, MINOR)
    found = key(rng, "major", "mixolydian")
    return found, harmony(rng, found, POP + ROCK)


def backbeat(rng: Random) -> Groove:
    """A bar or two with the snare on two and four."""
    lanes = {"kick": rng.choice(KICKS), "snare": rng.choice(SNARES), "hat": rng.choice(HATS)}
    if rng.random() < 0.3:
        lanes = {name: line + (rng.choice(KICKS) if name == "kick" else line) for name, line in lanes.items()}
        return Groove(lanes, 2)
    return Groove(lanes)


def half_time(rng: Random) -> Groove:
    """The snare on three."""
    kick = rng.choice(["X.......", "X..x....", "X.....x.", "X.x.....", "X..x...x"]) + rng.choice(
        ["........", "..x.....", "...x..x."]
    )
    return Groove({"kick": kick, "snare": "........X.......", "hat": rng.choice(HATS)})


def band(rng: Random, lead: str = "lead") -> list[Seat]:
    """Bass and harmony instruments of a rock band, and a voice or solo instrument."""
    comp: Player = Comp(rng, GUITAR, 55, 3, rng.uniform(0.5, 0.95), rng.choice([0, 0.02]))
    if rng.random() < 0.45:
        others: list[Player] = [
            Comp(rng, GUITAR, 57, 3, rng.uniform(0.5, 0.95)),
            Arpeggio(rng, 2, voices=4),
            Pad(rng, 55, 3),
            Figure(rng, weave(rng, COMMON, 0.6, 1, 0.4), low=40, power=rng.random() < 0.5),
        ]
        comp = Varied(rng, [comp, *rng.sample(others, 2)])
    seats = [
        Seat(
            "bass",
            Bass(rng, DRIVE, rng.choice(["root", "root", "fifth", "scale", "octave"])),
            program(rng, "bass"),
            1.0,
        ),
        Seat(
            "comp",
            comp,
            program(rng, "electric", "distorted", "steel"),
            0.8,
        ),
    ]
    draw = rng.random()
    if draw < 0.35:
        seats.append(
            Seat("pad", Pad(rng, 62, rng.choice([3, 4])), program(rng, "organ", "strings", "pad", "epiano"), 0.7)
        )
    elif draw < 0.6:
        seats.append(
            Seat("comp2", Arpeggio(rng, rng.choice([2, 4]), voices=4), program(rng, "steel", "electric", "piano"), 0.8)
        )
    if rng.random() < 0.7:
        melody = Melody(rng, 58, 82, rng.uniform(0.2, 0.7), rng.uniform(0.05, 0.35))
        seats.append(Seat(lead, melody, program(rng, "lead", "distorted", "reeds", "choir", "flutes", "violin"), 0.9))
        if rng.random() < 0.2:
            seats.append(Seat(lead, Shadow(melody), program(rng, "lead", "choir", "electric"), 0.7))
    return seats


@style("rock", "band", 3.0)
def rock(rng: Random) -> Plan:
    found, chords = rock_harmony(rng)
    drummer = Drummer(
        rng,
        backbeat(rng),
        backbeat(rng),
        rng.choice([4, 4, 8, 2]),
        ghosts=rng.choice([0, 0, 0.08]),
        free=rng.choice([0.0, 0.1, 0.25]),
    )
    seats = [Seat("drums", drummer, kit(rng)), *band(rng)]
    return Plan(rng.triangular(84, 160, 118), seats, chords, found, sections=song(rng, {seat.role for seat in seats}))


@style("half time rock", "band", 1.6)
def slow_rock(rng: Random) -> Plan:
    """Half-time feel: eighth or sixteenth hats, one snare per bar: tapped at the quarter."""
    found, chords = rock_harmony(rng)
    drummer = Drummer(rng, half_time(rng), half_time(rng) if rng.random() < 0.6 else backbeat(rng))
    return Plan(rng.triangular(95, 160, 125), [Seat("drums", drummer, kit(rng)), *band(rng)], chords, found)
