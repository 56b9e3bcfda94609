"""Songs without drums, or nearly: piano ballads, keys, strummed and plucked guitars, choirs with claps, music boxes."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Groove
from training.music.harmony import CLASSICAL, MINOR, POP, Key, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.piece import COMMON, THREE, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony


def pop_key(rng: Random) -> tuple[Key, list[str]]:
    """A key with the progressions that go with it."""
    found = key(rng, "major", "major", "minor")
    return found, MINOR if found.scale == "minor" else POP


def left_hand(rng: Random, metre: Metre) -> Bass | Arpeggio:
    """A pianist's left hand: roots and octaves, or broken tenths."""
    four = ["X.......", "X...X...", "X..xX...", "X...X.x.", "X..xX..x", "X.....x."]
    three = ["X.....", "X...x.", "X..x..", "X.x.x."]
    if rng.random() < 0.6:
        return Bass(
            rng,
            four if metre.beats == 4 else three,
            rng.choice(["root", "octave", "fifth"]),
            rng.choice([28, 33, 36]),
            1.0,
        )
    return Arpeggio(rng, rng.choice([1, 2, 2]), rng.choice([(0, 2, 3, 2), (0, 1, 2, 3), (0, 2, 4, 2), None]), 45, 3)


def right_hand(rng: Random, metre: Metre) -> Comp | Arpeggio:
    """A pianist's right hand as accompaniment: block chords on the beats, off-beats, arpeggios."""
    blocks = ["x.x.x.x.", "X.......", "X...X...", "xxxxxxxx", "X.x.X.x.", "X..x..x.", "..x...x.", "X..x..x.X...x..."]
    if metre.beats == 3:
        blocks = ["x.x.x.", "X.....", "..x.x.", "xxxxxx", "X..x.."]
    if rng.random() < 0.55:
        return Comp(
            rng,
            blocks,
            rng.randint(58, 68),
            rng.choice([3, 3, 4]),
            rng.uniform(0.7, 1.0),
            anticipate=rng.choice([0, 0, 0.2]),
        )
    return Arpeggio(rng, rng.choice([2, 2, 4, 4]), None, 62, 3, rng.uniform(1.0, 2.0))


@style("piano ballad", "ballad", 2.4)
def piano_ballad(rng: Random) -> Plan:
    """Piano alone, or with a voice or strings; slow; chords on beats, a melody with pickups."""
    found, lines = pop_key(rng)
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    piano = program(rng, "piano", "piano", "epiano")
    seats = [Seat("bass", left_hand(rng, metre), piano), Seat("comp", right_hand(rng, metre), piano, 0.9)]
    if rng.random() < 0.8:
        voice = piano if rng.random() < 0.5 else program(rng, "choir", "reeds", "flutes", "violin", "lead")
        seats.append(
            Seat("lead", Melody(rng, 60, 80, rng.uniform(0.25, 0.65), rng.uniform(0.1, 0.3), pickup=0.6), voice)
        )
    if rng.random() < 0.25:
        seats.append(Seat("pad", Pad(rng, 60), program(rng, "strings", "pad"), 0.6))
    return Plan(
        rng.triangular(50, 104, 68),
        seats,
        harmony(rng, found, lines, 0.15),
        found,
        metre,
        timing=rng.choice(["human", "human", "expressive"]),
        drift=rng.uniform(0.01, 0.05),
    )


@style("keys", "ballad", 1.6)
def keys(rng: Random) -> Plan:
    """Keyboards without drums at a walking or dancing pace."""
    found, lines = pop_key(rng)
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    comp = Comp(
        rng,
        ["X.x.X.x.", "xxxxxxxx", "..x...x.", "X..x..x.", "X..x.x..", "X.xx.xx.", ""],
        62,
        rng.choice([3, 4]),
        rng.uniform(0.4, 0.9),
        anticipate=rng.choice([0, 0.3]),
    )
    seats = [
        Seat(
            "comp",
            comp if metre.beats == 4 else right_hand(rng, metre),
            program(rng, "epiano", "organ", "piano", "accordion"),
        ),
        Seat("bass", left_hand(rng, metre), program(rng, "piano", "bass", "synth bass")),
    ]
    if rng.random() < 0.7:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 60, 84, rng.uniform(0.3, 0.8), 0.25),
                program(rng, "lead", "epiano", "bells", "flutes"),
            )
        )
    return Plan(
        rng.triangular(84, 144, 114),
        seats,
        harmony(rng, found, lines, 0.1),
        found,
        metre,
        timing=rng.choice(["human", "machine"]),
        drift=0.012,
    )


@style("choir with claps", "ballad", 0.8)
def choir(rng: Random) -> Plan:
    """Voices in chords, hands on two and four or on each beat; or no hands at all."""
    found, lines = pop_key(rng)
    claps = {"clap": rng.choice(["....X.......X...", "X...X...X...X...", "....X.......X.x.", "....X..x....X..."])}
    if rng.random() < 0.4:
        claps["kick"] = rng.choice(["X.......X.......", "X.x.....X.x....."])
    seats = [
        Seat(
            "pad",
            Comp(rng, ["X.......", "X...X...", "X...X.x.", "X.x.X.x.", "X..xx..."], 60, 4, 1.0),
            program(rng, "choir", "organ", wild=0.02),
        ),
        Seat("bass", Bass(rng, ["X...X...", "X.......", "X..xX..."], "root", 36, 1.0), program(rng, "choir", wild=0)),
        Seat("lead", Melody(rng, 60, 79, 0.4, 0.3), program(rng, "choir", "reeds")),
    ]
    if rng.random() < 0.7:
        seats.append(Seat("drums", Percussion(rng, Groove(claps)), kit(rng)))
    return Plan(
        rng.triangular(66, 132, 96), seats, harmony(rng, found, [*lines, *CLASSICAL[:2]], 0.1), found, drift=0.015
    )


@style("music box", "ballad", 0.6)
def music_box(rng: Random) -> Plan:
    found, lines = pop_key(rng)
    metre = rng.choice([COMMON, THREE, THREE])
    box = program(rng, "music box", "mallets", "bells", "harp", wild=0.05)
    seats = [
        Seat("lead", Melody(rng, 72, 96, rng.uniform(0.3, 0.7), 0.08), box),
        Seat(
            "comp",
            either(
                rng,
                Arpeggio(rng, 2, centre=64),
                Comp(rng, ["X...X...", "X.x.X.x."] if metre.beats == 4 else ["X.x.x.", "..x.x."], 62, 2),
            ),
            box,
            0.8,
        ),
    ]
    return Plan(
        rng.triangular(60, 150, 104),
        seats,
        harmony(rng, found, lines),
        found,
        metre,
        timing=rng.choice(["machine", "human", "expressive"]),
        drift=0.03,
    )
