"""Romantic piano: etudes, nocturnes, romances; with rubato."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Arpeggio, Comp
from training.music.harmony import MINOR, POP
from training.music.melody import Melody
from training.music.piece import COMMON, JIG, THREE, TWELVE, TWO, Feel
from training.music.programs import program
from training.music.registry import style
from training.music.styles.classical import hands
from training.music.styles.rock import harmony
from training.music.styles.waltz import old_key


@style("etude", "romantic", 1.4)
def etude(rng: Random) -> Plan:
    """Figuration through all registers, a slow tune on the beats above, octaves below; or the tune in the left hand."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, COMMON, COMMON, TWO, THREE, JIG])
    rate = rng.choice([3, 6]) if metre.div == 3 else rng.choice([4, 4, 4, 6, 3])
    piano = 0 if rng.random() < 0.7 else program(rng, "piano")
    figure = Arpeggio(
        rng,
        rate,
        rng.choice(
            [
                None,
                (0, 1, 2, 3, 4, 5, 6, 7),
                (0, 2, 1, 3, 2, 4, 3, 5),
                (4, 2, 3, 1, 2, 0),
                (0, 3, 1, 4, 2, 5),
                (0, 4, 2, 4),
            ]
        ),
        rng.randint(54, 70),
        rng.choice([3, 4]),
        rng.uniform(0.8, 2.0),
        0.5,
        rng.uniform(0.0, 0.25),
    )
    seats = [
        Seat("arpeggio", figure, piano, feel=hands(rng)),
        Seat(
            "bass",
            Bass(
                rng,
                ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats, "X.X" + "." * (2 * metre.beats - 3)],
                rng.choice(["root", "octave", "arpeggio"]),
                28,
                1.0,
            ),
            piano,
            feel=hands(rng),
        ),
    ]
    if rng.random() < 0.65:
        low = rng.random() < 0.25
        seats.append(
            Seat(
                "lead",
                Melody(rng, 43 if low else 67, 62 if low else 88, rng.uniform(0, 0.4), 0.05, 0.08),
                piano,
                1.1,
                feel=hands(rng),
            )
        )
    bpm = rng.triangular(56, 150, 92) * (0.8 if rate == 6 else 1.0)
    return Plan(
        bpm,
        seats,
        harmony(rng, found, lines, 0.15),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.04, 0.2),
        sections=[("a", 0.6, None), ("b", 0.9, None)],
    )


@style("nocturne", "romantic", 1.2)
def nocturne(rng: Random) -> Plan:
    """Wide broken chords in eighths or triplets, a free melody above; the beats lie where the bass is."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, TWELVE, TWELVE, THREE, JIG])
    piano = program(rng, "piano", "piano", "nylon", "harp", wild=0.02)
    rate = 3 if metre.div == 3 else rng.choice([2, 3, 4])
    left = Arpeggio(
        rng, rate, rng.choice([(0, 2, 4), (0, 2, 4, 3, 4, 2), (0, 3, 4, 2, 4, 3), (0, 2, 3, 2)]), 44, 3, 2.0, 0.45
    )
    right = Melody(rng, 64, 86, rng.uniform(0.2, 0.7), 0.12, 0.1, 0.5)
    free = Feel(jitter=rng.uniform(0.004, 0.02), push=rng.uniform(0.0, 0.02))
    seats = [
        Seat("arpeggio", left, piano, feel=hands(rng)),
        Seat(
            "lead", right, piano if rng.random() < 0.7 else program(rng, "violin", "flutes", "solo strings"), 1.1, free
        ),
    ]
    return Plan(
        rng.triangular(40, 100, 62),
        seats,
        harmony(rng, found, lines, 0.1),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.05, 0.2),
    )


@style("romance", "romantic", 0.9)
def romance(rng: Random) -> Plan:
    """Songs and character pieces: repeated chords in eighths or after the beat, a bass and a tune."""
    found, lines = old_key(rng)
    metre = rng.choice([COMMON, TWO, THREE, TWELVE])
    piano = program(rng, "piano", wild=0.02)
    count = metre.beats * metre.div
    chords = rng.choice(["x" * count, ("." + "x" * (metre.div - 1)) * metre.beats, "o" * count])
    seats = [
        Seat(
            "bass",
            Bass(rng, ["X" + "." * (2 * metre.beats - 1), "X." * metre.beats], "root", 33, 1.0),
            piano,
            feel=hands(rng),
        ),
        Seat("comp", Comp(rng, [chords], 58, 3, 0.8), piano, 0.8, hands(rng)),
        Seat(
            "lead",
            Melody(rng, 62, 84, rng.uniform(0.2, 0.5), 0.08, 0.08, 0.6),
            piano if rng.random() < 0.5 else program(rng, "violin", "solo strings", "choir", "reeds"),
        ),
    ]
    more = POP[:8] if found.scale == "major" else MINOR[:6]
    return Plan(
        rng.triangular(48, 132, 80),
        seats,
        harmony(rng, found, [*lines, *more], 0.1),
        found,
        metre,
        timing="expressive",
        drift=rng.uniform(0.03, 0.14),
    )
