"""Without drums: piano, guitar, strings, a walking bass, a voice over held chords, mallets, alone or in twos."""

from random import Random

from training.music.bass import Bass, Walk
from training.music.build import Plan, Player, Seat, Varied, either
from training.music.comping import Arpeggio, Comp, Oompah, Pad
from training.music.figure import Figure, Shadow
from training.music.harmony import BLUES, CLASSICAL, JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.piece import COMMON, JIG, THREE, TWELVE, Metre
from training.music.programs import program
from training.music.registry import style
from training.music.styles.ballads import left_hand, pop_key, right_hand
from training.music.styles.rock import harmony


def freely(rng: Random, seats: list[Seat], metre: Metre, bpm: float, swing: float = 0.5) -> Plan:
    """A plan for one or two people who have no drummer: some strict, some with rubato."""
    found, lines = pop_key(rng)
    more = [*JAZZ[:4], *CLASSICAL[:3]] if found.scale == "major" else []
    timing = rng.choice(["human", "human", "expressive"])
    drift = rng.uniform(0.01, 0.025) if timing == "human" else rng.uniform(0.02, 0.08)
    chords = harmony(rng, found, [*lines, *more], 0.12)
    return Plan(bpm, seats, chords, found, metre, timing=timing, drift=drift, swing=swing)


@style("solo piano", "solo", 2.6)
def solo_piano(rng: Random) -> Plan:
    """Both hands change what they do from section to section; a tune in the right hand for most."""
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    keys = program(rng, "piano", "piano", "epiano", wild=0.01)
    stride = Oompah(rng, 60, 40)
    left: list[Player] = [left_hand(rng, metre), left_hand(rng, metre), stride]
    right: list[Player] = [right_hand(rng, metre), right_hand(rng, metre)]
    seats = [Seat("bass", Varied(rng, left), keys), Seat("comp", Varied(rng, right), keys, 0.85)]
    if rng.random() < 0.75:
        seats.append(Seat("lead", Melody(rng, 64, 86, rng.uniform(0.3, 0.8), rng.uniform(0.05, 0.35)), keys, 1.15))
    return freely(rng, seats, metre, rng.triangular(56, 176, 104), rng.choice([0.5, 0.5, 0.5, 0.62]))


@style("solo guitar", "solo", 2.2)
def solo_guitar(rng: Random) -> Plan:
    """Finger-style: thumb on the beats, broken chords or chops, a tune on top; or riffs alone."""
    metre = rng.choice([COMMON, COMMON, THREE, JIG])
    guitar = program(rng, "nylon", "steel", "electric", wild=0)
    units = metre.beats * metre.div
    thumb = Bass(rng, [("X" + "." * (metre.div - 1)) * metre.beats, "X" + "." * (units - 1)], "fifth", 40, 1.0)
    chop = ("." + "x" * (metre.div - 1)) * metre.beats
    fingers = either(rng, Arpeggio(rng, metre.div, None, 59, 3, 1.5), Comp(rng, [chop, ""], 60, 3, 0.6, 0.01))
    seats = [Seat("bass", thumb, guitar), Seat("comp", fingers, guitar, 0.85)]
    if rng.random() < 0.2:
        riff = [(0.0, 1.0), *[hit for hit in weave(rng, metre, 0.6, 1, 0.4) if hit[0] > 0]]
        seats = [Seat("comp", Figure(rng, riff, (0, 0, 3, 5, 7, 10), 40, power=rng.random() < 0.5), guitar)]
    elif rng.random() < 0.6:
        seats.append(Seat("lead", Melody(rng, 64, 81, rng.uniform(0.3, 0.7), 0.2), guitar, 1.1))
    return freely(rng, seats, metre, rng.triangular(60, 168, 104))


@style("string players", "solo", 1.7)
def string_players(rng: Random) -> Plan:
    """Bowed or plucked strings: ostinatos in eighths, broken chords of one cello, a tune and its second voice."""
    metre = rng.choice([COMMON, COMMON, THREE, JIG, TWELVE])
    group = rng.choice(["strings", "solo strings", "pizzicato", "strings"])
    first = Melody(rng, 62, 84, rng.uniform(0.2, 0.8), 0.1, silence=0.0)
    pulse = "X" + "x" * (metre.div - 1)
    inner = either(
        rng,
        Comp(rng, [pulse * metre.beats, "x" * metre.beats * metre.div, ""], 60, 3, 0.7),
        Arpeggio(rng, 3 if metre.div == 3 else rng.choice([2, 4]), None, 55, 3, 0.9),
    )
    seats = [Seat("comp", inner, program(rng, group, wild=0.01))]
    if rng.random() < 0.7:
        seats.append(Seat("lead", first, program(rng, "violin", "strings", "solo strings", wild=0.01)))
        if rng.random() < 0.4:
            seats.append(Seat("second", Shadow(first), program(rng, "strings"), 0.8))
    if rng.random() < 0.7:
        bass = Bass(rng, [("X" + "." * (metre.div - 1)) * metre.beats, "X" + "." * (metre.beats * metre.div - 1)])
        seats.append(Seat("bass", bass, program(rng, "strings", "solo strings", "pizzicato", wild=0.01)))
    return freely(rng, seats, metre, rng.triangular(58, 160, 100))


@style("walking bass", "solo", 1.3)
def walking(rng: Random) -> Plan:
    """A bass that walks, alone or with a guitar, a voice, a horn, brushes of chords."""
    found = key(rng, "major", "dorian")
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    seats = [Seat("bass", Walk(rng, skips=rng.choice([0.0, 0.1, 0.25])), program(rng, "upright", "bass", wild=0.02))]
    if rng.random() < 0.4:
        comp = Comp(rng, ["", "x" + "..x" * 5] if metre.beats == 4 else [""], 60, 4, 0.4, anticipate=0.1)
        seats.append(Seat("comp", comp, program(rng, "electric", "piano", "epiano")))
    if rng.random() < 0.4:
        seats.append(
            Seat("lead", Melody(rng, 58, 82, 0.6, 0.35), program(rng, "reeds", "solo brass", "choir", "mallets"))
        )
    chords = harmony(rng, found, JAZZ + BLUES[:2], 0.1)
    return Plan(rng.uniform(72, 204), seats, chords, found, metre, swing=rng.uniform(0.54, 0.67), drift=0.015)


@style("voice and pad", "solo", 1.7)
def voice_and_pad(rng: Random) -> Plan:
    """A voice-like lead over chords that are held or struck on the beats; nothing else, or a slow bass."""
    metre = rng.choice([COMMON, COMMON, THREE])
    voice = Melody(rng, 57, 78, rng.uniform(0.35, 0.8), rng.uniform(0.1, 0.35), 0.1, 0.6, silence=0.0)
    held: Player = Pad(rng, 58, 4)
    if rng.random() < 0.45:
        held = Comp(rng, ["X." * metre.beats, "X" + "." * (2 * metre.beats - 1), ""], 58, 4, 1.0)
    seats = [
        Seat("lead", voice, program(rng, "choir", "reeds", "lead", "solo brass", "violin", "pipes"), 1.1),
        Seat("pad", held, program(rng, "pad", "strings", "organ", "choir", "accordion", "epiano"), 0.75),
    ]
    if rng.random() < 0.35:
        seats.append(Seat("bass", Bass(rng, ["X.......", "X...X..."] if metre.beats == 4 else ["X....."], "root"), 33))
    return freely(rng, seats, metre, rng.triangular(56, 148, 92))


@style("mallets", "solo", 1.0)
def mallets(rng: Random) -> Plan:
    """Marimbas and vibraphones in patterns that repeat and lock into each other."""
    found = key(rng, "major", "dorian", "lydian", "pentatonic")
    metre = rng.choice([COMMON, COMMON, THREE, TWELVE])
    sound = program(rng, "mallets", "bells", "music box", wild=0.02)
    rate = 3 if metre.div == 3 else rng.choice([2, 4])
    seats = [
        Seat("arpeggio", Arpeggio(rng, rate, None, 64, 3, 0.8, 0.55, 0.25, rng.choice([0, 0.2])), sound),
        Seat("comp", Figure(rng, weave(rng, metre, 0.6, 1, 0.5), (0, 4, 7, 12), 48), sound),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 66, 86, 0.6, 0.2), sound))
    chords = harmony(rng, found, POP[:8] if found.scale != "dorian" else MINOR[:6])
    timing = rng.choice(["human", "machine"])
    return Plan(rng.uniform(72, 156), seats, chords, found, metre, timing=timing, drift=0.01)


@style("two guitars", "solo", 0.8, held_out=True)
def two_guitars(rng: Random) -> Plan:
    """One strums or plays chops, one plays the tune; strings of steel or nylon."""
    metre = rng.choice([COMMON, COMMON, THREE, JIG])
    rhythm = "X" + "." * (metre.div - 1)
    lines = [rhythm * metre.beats, "x" * metre.beats * metre.div, ("." + "x" * (metre.div - 1)) * metre.beats]
    one = either(rng, Comp(rng, lines, 58, 4, 0.7, 0.015), Arpeggio(rng, metre.div, None, 57, 4, 1.2), Oompah(rng))
    tune = Melody(rng, 62, 83, rng.uniform(0.4, 0.85), 0.2)
    sound = program(rng, "nylon", "steel", wild=0)
    return freely(rng, [Seat("comp", one, sound), Seat("lead", tune, sound, 1.1)], metre, rng.uniform(66, 160))


@style("organ alone", "solo", 0.8, held_out=True)
def organ_alone(rng: Random) -> Plan:
    """An organ or an accordion with both hands."""
    metre = rng.choice([COMMON, THREE, JIG])
    sound = program(rng, "organ", "accordion", wild=0)
    pulse = ("X" + "." * (metre.div - 1)) * metre.beats
    left = either(rng, Bass(rng, [pulse], "fifth", 40), Oompah(rng, halves=metre.beats == 2))
    seats = [Seat("bass", left, sound), Seat("lead", Melody(rng, 64, 84, rng.uniform(0.3, 0.8), 0.15), sound)]
    if rng.random() < 0.5:
        seats.append(Seat("comp", Comp(rng, [pulse, "x" * metre.beats * metre.div, ""], 60, 3, 0.7), sound, 0.8))
    return freely(rng, seats, metre, rng.uniform(64, 150))
