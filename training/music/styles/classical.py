"""Baroque and classical: alberti sonatas, running preludes, inventions, chorales, quartets, concertos."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Player, Seat, Varied
from training.music.comping import Arpeggio, Comp, Oompah
from training.music.figure import Shadow
from training.music.melody import Melody
from training.music.pattern import Pattern
from training.music.piece import COMMON, JIG, THREE, TWO, Feel, Metre
from training.music.programs import program
from training.music.registry import style
from training.music.styles.rock import harmony
from training.music.styles.waltz import old_key


def hands(rng: Random) -> Feel:
    """A soloist's two hands play together: no habits of push, little jitter."""
    return Feel(jitter=rng.uniform(0.001, 0.007), touch=rng.uniform(0.06, 0.16))


def even(metre: Metre, rate: int) -> Pattern:
    """So many equal notes per beat through the bar."""
    return [(step / rate, 1.0) for step in range(metre.beats * rate)]


@style("sonata", "classical", 1.8)
def sonata(rng: Random) -> Plan:
    """Alberti bass or drummed eighths in the left hand, a singing or running right hand; expressive."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, TWO, THREE, JIG])
    piano = program(rng, "piano", "piano", "piano", "harpsichord", wild=0.02)
    rate = 3 if metre.div == 3 else rng.choice([2, 2, 4])
    textures: list[Player] = [
        Arpeggio(rng, rate, (0, 2, 1, 2) if rate != 3 else rng.choice([(0, 1, 2), (0, 2, 1)]), 50, 3, 0.9, 0.5),
        Comp(
            rng,
            ["x" * metre.beats * (3 if metre.div == 3 else 2), ("X" + "." * (metre.div - 1)) * metre.beats],
            52,
            3,
            0.6,
        ),
        Bass(rng, ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats], "arpeggio", 40),
        Oompah(rng, 54, 40, metre.beats == 2),
        Melody(rng, 43, 62, rng.uniform(0.2, 0.8), 0.02, 0.1, leap=0.35),
    ]
    left = Varied(rng, textures) if rng.random() < 0.7 else rng.choice(textures)
    paces = [rng.uniform(0.3, 0.95) for _ in range(3)]
    fancy = rng.choice([0.0, 0.05, 0.15])
    lines_above = [
        Melody(rng, 62, 88, pace, 0.04, 0.1, 0.4, rng.choice([0.15, 0.3]), silence=0.03, ornaments=fancy)
        for pace in paces
    ]
    right: Player = Varied(rng, lines_above) if rng.random() < 0.6 else lines_above[0]
    seats = [Seat("bass", left, piano, feel=hands(rng)), Seat("lead", right, piano, feel=hands(rng))]
    if right is lines_above[0] and rng.random() < 0.4:
        seats.append(Seat("second", Shadow(lines_above[0], rng.choice([-2, -2, -7])), piano, 0.8))
    slow = rng.random() < 0.35
    bpm = rng.uniform(44, 84) if slow else rng.triangular(84, 168, 122)
    return Plan(
        bpm,
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.02, 0.09),
        lengths=(4, 8, 8),
    )


@style("prelude", "classical", 1.5)
def prelude(rng: Random) -> Plan:
    """One figure through all bars, the harmony changes with the bar; sixteenths that never stop."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, THREE, TWO, JIG])
    rate = 3 if metre.div == 3 else rng.choice([4, 4, 4, 3, 2])
    shape = rng.choice(
        [
            (0, 1, 2, 3, 4, 2, 3, 4),
            None,
            (0, 2, 1, 2),
            (0, 1, 2, 1),
            (0, 3, 2, 1),
            (4, 3, 2, 1, 0, 1, 2, 3),
            (0, 4, 3, 4, 2, 4, 1, 4),
        ]
    )
    instrument = program(rng, "piano", "harpsichord", "nylon", "organ", "harp", "solo strings")
    seats = [
        Seat(
            "arpeggio",
            Arpeggio(
                rng,
                rate,
                shape,
                rng.randint(54, 66),
                rng.choice([3, 4, 5]),
                rng.uniform(0.8, 3.0),
                accent=rng.uniform(0, 0.2),
            ),
            instrument,
            feel=hands(rng),
        )
    ]
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "bass",
                Bass(
                    rng,
                    ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats],
                    rng.choice(["root", "arpeggio"]),
                    36,
                    1.0,
                ),
                instrument,
                feel=hands(rng),
            )
        )
    if rng.random() < 0.3:
        seats.append(Seat("lead", Melody(rng, 70, 88, 0.1, 0.02, 0.2), instrument, feel=hands(rng)))
    return Plan(
        rng.triangular(52, 120, 76),
        seats,
        harmony(rng, found, lines, 0.1),
        found,
        metre,
        timing=rng.choice(["expressive", "expressive", "human"]),
        drift=rng.uniform(0.015, 0.08),
        form="one",
        sections=[("a", 0.6, None)],
        lengths=(8, 16),
    )


@style("invention", "classical", 1.0)
def invention(rng: Random) -> Plan:
    """Two or three voices: sixteenths in one, eighths in the other, changing over."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, THREE, JIG])
    fast, slow = (3, 1) if metre.div == 3 else rng.choice([(4, 2), (4, 1), (2, 1)])
    instrument = program(rng, "harpsichord", "piano", "organ", "strings", "flutes")
    other = instrument if rng.random() < 0.6 else program(rng, "strings", "reeds", "solo strings")
    free = rng.random() < 0.5
    upper = Melody(rng, 64, 84, 0.85, 0.05, 0.05, given=None if free else even(metre, fast))
    lower = Melody(
        rng, 43, 62, 0.5, 0.03, 0.05, leap=0.35, given=None if free and rng.random() < 0.4 else even(metre, slow)
    )
    seats = [Seat("lead", upper, instrument, feel=hands(rng)), Seat("bass", lower, other, feel=hands(rng))]
    if rng.random() < 0.3:
        seats.append(Seat("second", Melody(rng, 55, 72, 0.4, 0.05, 0.2), instrument))
    return Plan(
        rng.triangular(56, 112, 80),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing=rng.choice(["expressive", "human"]),
        drift=rng.uniform(0.01, 0.05),
        sections=[("a", 0.6, None), ("b", 0.7, None)],
    )
