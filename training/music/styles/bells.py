"""West Africa and what came of it: bells in twelve-eight and in four, afrobeat, highlife, soukous, second line."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Arpeggio, Comp
from training.music.drums import Drummer, Groove
from training.music.figure import Figure
from training.music.harmony import BLUES, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.percussion import Percussion
from training.music.piece import COMMON, TWELVE
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.drums_alone import silent
from training.music.styles.rock import harmony

BELL_SOUNDS = ["cowbell", "agogo1", "agogo2", "block1", "claves", "bell", "tri"]
STANDARD = ["X.x.xx.x.x.x", "X.x.xx.x.x.x", "X.x.x.xx.x.x", "X.xx.x.xx.x.", "x.x.x..x.x.."]
FOUR = ["X..x..x...x...x.", "X..x..x...x.x...", "X..x..x.x.x...x.", "X.x.x.xx.x.x.xx.", "X..x...x..x.x..."]


@style("bell of twelve", "timeline", 2.2)
def bell_of_twelve(rng: Random) -> Plan:
    """The standard bell alone, or with a rattle on the beats and drums of threes and twos; counted in four."""
    found, chords = silent(rng)
    bell = {rng.choice(BELL_SOUNDS): rng.choice(STANDARD)}
    more = {
        rng.choice(["shaker", "cabasa", "clap"]): rng.choice(["X..X..X..X..", "X.xX.xX.xX.x", "XxxXxxXxxXxx"]),
        "conga2": rng.choice(["...x.....x..", "X..x..X..x..", "..xx....xx..", "......X....."]),
        "conga": rng.choice([".xx.xx.xx.xx", "..x..x..x..x", "x.xx..x.xx.."]),
        "tom6": rng.choice(["X.....x.....", "X...........", "X...x.X.x..."]),
    }
    for name in rng.sample(sorted(more), rng.choice([0, 1, 1, 2, 3, 4])):
        bell[name] = more[name]
    seats = [Seat("percussion", Percussion(rng, Groove(bell), 0.03), kit(rng))]
    if rng.random() < 0.25:
        seats.append(Seat("lead", Melody(rng, 57, 77, 0.5, 0.2), program(rng, "choir", "mallets", "ethnic", "flutes")))
    sections = [("a", 0.7, None), ("b", 0.9, None)]
    return Plan(rng.uniform(72, 140), seats, chords, found, TWELVE, drift=0.012, sections=sections)


def bell_in_four(rng: Random, alone: float) -> Plan:
    """A bell in sixteenths, alone or with a rattle and drums."""
    found, chords = silent(rng)
    lanes = {rng.choice(BELL_SOUNDS): rng.choice(FOUR)}
    more = {
        rng.choice(["shaker", "cabasa"]): rng.choice(["X.xxX.xxX.xxX.xx", "X...X...X...X...", "..x...x...x...x."]),
        "conga": rng.choice(["..xx..xx..xx..xx", "x..x..x.x..x..x.", "..x..xx...x..xx."]),
        rng.choice(["conga2", "tom6"]): rng.choice(["X.......X.x.....", "....X.......X...", "X..x......x....."]),
    }
    if rng.random() > alone:
        for name in rng.sample(sorted(more), rng.randint(1, 3)):
            lanes[name] = more[name]
    seats = [Seat("percussion", Percussion(rng, Groove(lanes), 0.03), kit(rng))]
    sections = [("a", 0.7, None), ("b", 0.9, None)]
    return Plan(rng.uniform(80, 132), seats, chords, found, drift=0.012, sections=sections)


@style("bell in four", "timeline", 1.2)
def bell_of_sixteen(rng: Random) -> Plan:
    return bell_in_four(rng, 0.35)


@style("gahu", "timeline", 1.0, held_out=True)
def gahu(rng: Random) -> Plan:
    """The bell of gahu with two bells' pitches; rattle and answering drums."""
    plan = bell_in_four(rng, 0.2)
    lanes = {"agogo2": "X...............", "agogo1": "...x..x...x...x."}
    bells = Seat("bells", Percussion(rng, Groove(lanes), 0.02), kit(rng))
    plan.seats[:] = [bells] if rng.random() < 0.25 else [bells, *plan.seats]
    return plan


@style("afrobeat", "timeline", 2.0)
def afrobeat(rng: Random) -> Plan:
    """A kit whose kick and snare fall beside the beats, sticks or a bell, a rattle; ostinatos of guitars and bass."""
    found = key(rng, "dorian", "minor", "minor pentatonic")
    lanes = {
        "kick": rng.choice(["X..x......x.x...", "X.....x...x..x..", "x..X..x...X.....", "X..x..x.....x..."]),
        "snare": rng.choice(["....o..x....x..o", "......x...o...x.", "....x..o.o..x...", ".......x..o....x"]),
        "hat": rng.choice(["x.x.x.x.x.x.x.x.", "xoxoxoxoxoxoxoxo", "x.xxx.xxx.xxx.xx", "x..xx..xx..xx..x"]),
    }
    hand = {
        rng.choice(["claves", "cowbell", "stick"]): rng.choice(
            ["x..x..x...x.x...", "x..x...x..x.x...", "x.x.xx.x.xx.x.x."]
        ),
        rng.choice(["shaker", "cabasa"]): rng.choice(["X.xxX.xxX.xxX.xx", "xxxxxxxxxxxxxxxx"]),
    }
    riff = [(0.0, 1.0), *[hit for hit in weave(rng, COMMON, 0.4, 2, 0.1) if hit[0] > 0]]
    tenor = Figure(rng, weave(rng, COMMON, 0.5, 2, 0.0), (0, 3, 5, 7, 10, 12), 50)
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), None, 8, 0.3, 0.3, free=0.1), kit(rng)),
        Seat("percussion", Percussion(rng, Groove(hand)), kit(rng)),
        Seat("bass", Figure(rng, riff, (0, 0, 7, 10, 5), 30), program(rng, "bass")),
        Seat("comp", tenor, program(rng, "electric", "nylon")),
    ]
    if rng.random() < 0.6:
        seats.append(
            Seat(
                "comp2", Comp(rng, ["..x..x..", "..x...x.", ".xx..xx."], 62, 3, 0.3), program(rng, "electric", "organ")
            )
        )
    if rng.random() < 0.6:
        seats.append(Seat("lead", Melody(rng, 55, 77, 0.6, 0.4), program(rng, "reeds", "brass", "choir", "organ")))
    chords = harmony(rng, found, ["i7 i7 i7 i7", "i7 IV7", "i7 i7 bVII i7"])
    return Plan(rng.uniform(92, 130), seats, chords, found, drift=0.01, lengths=(8, 8, 16))


@style("highlife and soukous", "timeline", 1.5)
def highlife(rng: Random) -> Plan:
    """Guitars that interlock in a major key, a bell in clave, a snare or hat beside the beat, the bass in leaps."""
    found = key(rng, "major")
    lanes = {
        "kick": rng.choice(["X...X...X...X...", "X.......X.......", "x.....x...x....."]),
        rng.choice(["hat", "shaker"]): rng.choice(["..x...x...x...x.", "x.xxx.xxx.xxx.xx", "x.x.x.x.x.x.x.x."]),
        rng.choice(["claves", "cowbell", "rim"]): rng.choice(FOUR),
    }
    if rng.random() < 0.6:
        lanes["snare"] = rng.choice(["..x...x...x...x.", "...x..x....x..x.", "....x..x....x.xx"])
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), fills=0.4, crash=0.3), kit(rng)),
        Seat("comp", Arpeggio(rng, 4, None, 67, 3, 0.8, gaps=0.25), program(rng, "electric", "nylon", wild=0)),
        Seat("bass", Bass(rng, ["X..x..x.", "X.x...x.X.x...x.", "X..xX.x."], "arpeggio"), program(rng, "bass")),
    ]
    if rng.random() < 0.6:
        seats.append(Seat("arpeggio", Arpeggio(rng, 2, None, 60, 3, 0.8, gaps=0.1), program(rng, "electric")))
    if rng.random() < 0.7:
        seats.append(Seat("lead", Melody(rng, 58, 79, 0.6, 0.3), program(rng, "choir", "reeds", "solo brass")))
    chords = harmony(rng, found, ["I IV V IV", "I I IV V", "I,IV V,IV", "I IV I V", "ii V I I"])
    return Plan(rng.uniform(96, 140), seats, chords, found, drift=0.01)


@style("second line", "timeline", 1.5)
def second_line(rng: Random) -> Plan:
    """New Orleans: bass drum in clave with the big four, snare rolling in loose sixteenths, sousaphone, brass."""
    found = key(rng, "major", "mixolydian", "minor")
    lanes = {
        "kick": rng.choice(["X..x..x...x.X...", "X..X..x.....X...", "X.....x...x.X...", "X..x..X...x....."]),
        "snare": rng.choice(["x.xxoxx.xoxx.xx.", "o.XooXo.oXo.Xoo.", "x-xx-xx-x-xx-x-x", "..xx.x.x..xx.x.x"]),
        rng.choice(["cowbell", "tamb", "hat"]): rng.choice(
            ["x..x..x...x.x...", "X.x.X.x.X.x.X.x.", "..x...x...x...x."]
        ),
    }
    seats = [Seat("drums", Drummer(rng, Groove(lanes), fills=0.3, crash=0.4), kit(rng, "standard", "room"))]
    if rng.random() < 0.8:
        seats += [
            Seat(
                "bass", Bass(rng, ["X..x..x.", "X..xX.x.", "X.......X.x."], "arpeggio", 33, 0.7), program(rng, "tuba")
            ),
            Seat("lead", Melody(rng, 58, 80, 0.6, 0.4), program(rng, "solo brass", "reeds", "brass")),
        ]
        if rng.random() < 0.6:
            seats.append(
                Seat("brass", Comp(rng, ["x..x..x.........", "..x.x...", ""], 64, 3, 0.4), program(rng, "brass"))
            )
        if rng.random() < 0.4:
            seats.append(Seat("comp", Comp(rng, ["..x...x.", "x..x..x."], 60, 3, 0.5), program(rng, "piano", "nylon")))
    lines = ["i iv i V", "i i V i"] if found.scale == "minor" else ["I I V I", "I IV I V", *BLUES[:2]]
    fine = rng.uniform(0.5, 0.6)
    return Plan(rng.uniform(80, 124), seats, harmony(rng, found, lines), found, swing_fine=fine, drift=0.015)
