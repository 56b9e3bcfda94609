"""Metal: riffs, double kick, blast beats, doom; in four and in three."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Figure
from training.music.harmony import MINOR, ROCK, key
from training.music.melody import Melody
from training.music.pattern import Pattern, parse, weave
from training.music.piece import COMMON, THREE, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import backbeat, half_time, harmony

GALLOPS = [
    "X.xxX.xxX.xxX.xx",
    "xxxxxxxxxxxxxxxx",
    "X.xXx.xXX.xXx.x.",
    "XxxXxxXxxXxxXxXx",
    "X..X..X...X.X...",
    "X.x.X.xxX.x.x.xx",
    "X.xxxxX.X.xxxxX.",
]
LINES = [
    "i bVI bVII i",
    "i i bII i",
    "i bVII bVI bVII",
    "i bIII bII i",
    "i i i bVI,bVII",
    "i iv bII V",
    "i i i i",
    *MINOR,
]


def riff(rng: Random, metre: Metre) -> tuple[Pattern, int]:
    """A riff's rhythm of one or two bars: a gallop, or drawn."""
    if metre.beats == 4 and rng.random() < 0.5:
        return parse(rng.choice(GALLOPS), 4), 1
    bars = rng.choice([1, 2])
    whole = weave(rng, metre, rng.uniform(0.5, 0.95), 2, 0.5)
    if bars == 2:
        whole = whole + [(at + metre.beats, level) for at, level in weave(rng, metre, rng.uniform(0.4, 0.9), 2, 0.5)]
    if whole[0][0] > 0:
        whole.insert(0, (0.0, 1.0))
    return whole, bars


def riffs(rng: Random, metre: Metre, low: int = 28) -> list[Seat]:
    """Two guitars and a bass in unison."""
    pattern, bars = riff(rng, metre)
    pool = rng.choice([(0, 0, 0, 3, 5, 7, 10), (0, 0, 1, 3, 0), (0, 0, 6, 5, 3), (0, 2, 3, 7), (0, 0, 0, 0, 12, 10)])
    guitar = Figure(rng, pattern, pool, low + 12, bars, power=rng.random() < 0.7, palm=rng.uniform(0.4, 0.9))
    bass = Figure(rng, pattern, pool, low, bars)
    bass._steps = guitar._steps = [0 if at == 0 else rng.choice(pool) for at, _ in pattern]
    return [Seat("comp", guitar, rng.choice([29, 30, 30]), 0.85), Seat("bass", bass, program(rng, "bass"), 1.0)]


@style("metal", "metal", 2.2)
def metal(rng: Random) -> Plan:
    """Double kick under a backbeat, gallops, half-time choruses."""
    found = key(rng, "minor", "phrygian", "harmonic")
    double = Groove(
        {
            "kick": rng.choice(["xxxxxxxxxxxxxxxx", "X.xxX.xxX.xxX.xx", "X.x.X.x.X.x.X.x."]),
            "snare": "....X.......X...",
            "hat": rng.choice(["X...X...X...X...", "X.x.X.x.X.x.X.x."]),
        }
    )
    drummer = Drummer(
        rng, rng.choice([double, backbeat(rng)]), rng.choice([double, half_time(rng), backbeat(rng)]), ghosts=0
    )
    seats = [Seat("drums", drummer, kit(rng)), *riffs(rng, COMMON)]
    if rng.random() < 0.6:
        seats.append(Seat("lead", Melody(rng, 64, 88, rng.uniform(0.4, 1.0), 0.15), program(rng, "distorted", "lead")))
    if rng.random() < 0.3:
        seats.append(Seat("pad", Pad(rng, 60), program(rng, "choir", "strings", "organ", "pad"), 0.8))
    return Plan(rng.triangular(90, 190, 132), seats, harmony(rng, found, LINES), found, drift=0.012)


@style("doom", "metal", 1.6)
def doom(rng: Random) -> Plan:
    """Slow and heavy: power chords that ring, a kit with room between; some with drawn riffs, some without drums."""
    found = key(rng, "minor", "phrygian", "blues")
    kick = rng.choice(["X.......", "X..x....", "X.....x.", "X...x..."]) + rng.choice(
        ["........", "..x.....", "x......."]
    )
    groove = Groove(
        {
            "kick": kick,
            "snare": rng.choice(["....X.......X...", "........X......."]),
            rng.choice(["hat", "open", "crash", "ride", "ride"]): rng.choice(["X...X...X...X...", "X.x.X.x.X.x.X.x."]),
        },
        time="open",
    )
    seats = [
        Seat("drums", Drummer(rng, groove, fill_every=rng.choice([2, 4])), kit(rng, "room", "power", "standard")),
        *(
            riffs(rng, COMMON)
            if rng.random() < 0.5
            else [
                Seat(
                    "comp",
                    Comp(rng, ["X.......", "X...X...", "X..x....", "X.....xx", "X.....X."], 45, 3, 1.0),
                    rng.choice([29, 30]),
                ),
                Seat(
                    "bass",
                    Bass(rng, ["X.......", "X...X...", "X..xX...", "xxxxxxxx"], "root", 26, 1.0),
                    program(rng, "bass"),
                ),
            ]
        ),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 58, 80, 0.25, 0.1), program(rng, "distorted", "lead", "organ", "choir")))
    if rng.random() < 0.3:
        seats.append(Seat("arpeggio", Arpeggio(rng, 2, voices=3), program(rng, "electric", "bells")))
    return Plan(rng.triangular(50, 100, 70), seats, harmony(rng, found, LINES), found, drift=0.015)


@style("blast", "metal", 0.8)
def blast(rng: Random) -> Plan:
    """Thrash and blast: sixteenths of kick and snare; the pulse is what guitars and cymbals say."""
    found = key(rng, "phrygian", "minor", "harmonic")
    hard = Groove({"kick": "X.X.X.X.X.X.X.X.", "snare": ".x.x.x.x.x.x.x.x", "hat": "X.x.X.x.X.x.X.x."})
    skank = Groove({"kick": "X...X...X...X...", "snare": "..X...X...X...X.", "hat": "X.X.X.X.X.X.X.X."})
    drummer = Drummer(rng, rng.choice([hard, skank]), rng.choice([skank, half_time(rng), backbeat(rng), hard]))
    seats = [Seat("drums", drummer, kit(rng)), *riffs(rng, COMMON)]
    return Plan(rng.uniform(110, 205), seats, harmony(rng, found, LINES), found, drift=0.015)


@style("metal in three", "metal", 0.8)
def metal_three(rng: Random) -> Plan:
    found = key(rng, "minor", "phrygian", "harmonic")
    groove = Groove(
        {
            "kick": rng.choice(["X.xxX.x.X.x.", "X.....x.....", "xxxxxxxxxxxx", "X.........xx"]),
            "snare": rng.choice(["........X...", "....X...X...", "......X....."]),
            "hat": rng.choice(["X.x.X.x.X.x.", "X...X...X..."]),
        }
    )
    seats = [Seat("drums", Drummer(rng, groove), kit(rng)), *riffs(rng, THREE)]
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 60, 84, 0.5, 0.1), program(rng, "distorted", "lead", "choir", "strings")))
    return Plan(rng.triangular(84, 185, 122), seats, harmony(rng, found, LINES), found, THREE)


@style("riff without drums", "metal", 0.8)
def riff_alone(rng: Random) -> Plan:
    """One or two instruments in a drawn riff; a synthesiser's drone under it."""
    found = key(rng, "minor", "phrygian", "dorian", "blues")
    metre = rng.choice([COMMON, COMMON, THREE])
    seats = riffs(rng, metre, rng.choice([28, 33, 40]))
    family = rng.choice(["distorted", "electric", "piano", "synth bass", "organ", "strings", "lead"])
    seats = [Seat(seat.role, seat.player, program(rng, family), seat.volume) for seat in seats]
    if rng.random() < 0.5:
        seats.append(Seat("pad", Pad(rng, 50, again=False), program(rng, "pad", "choir", "strings"), 0.7))
    return Plan(rng.triangular(58, 170, 104), seats, harmony(rng, found, [*LINES, *ROCK]), found, metre, drift=0.02)
