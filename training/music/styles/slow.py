"""Slow music, 45 to 78 beats a minute, whose beat is the slow level though eighths and sixteenths run through it."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Player, Seat
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Figure
from training.music.harmony import JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.percussion import Percussion
from training.music.piece import COMMON, JIG, THREE, TWELVE, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.ballads import pop_key
from training.music.styles.reggae import LINES, SAD
from training.music.styles.rock import harmony

SHAPES = [(0, 2, 1, 2), (0, 1, 2, 3), (0, 1, 2, 1), (0, 2, 3, 2), (0, 1, 2, 3, 4, 3, 2, 1), (0, 2, 1, 3), None]
TRIPLETS = [(0, 1, 2), (0, 2, 1), (0, 1, 2, 3, 2, 1), (0, 2, 3, 4, 3, 2), None]


def running(rng: Random, metre: Metre, centre: int = 60) -> Arpeggio:
    """Broken chords in eighths or sixteenths (in triplets where the metre has them)."""
    rate = 3 * rng.choice([1, 1, 1, 2]) if metre.div == 3 else rng.choice([2, 2, 4, 4])
    shape = rng.choice(TRIPLETS if metre.div == 3 else SHAPES)
    accent = rng.choice([0.0, 0.05, 0.15, 0.3])
    return Arpeggio(rng, rate, shape, centre, rng.choice([3, 3, 4]), rng.uniform(0.9, 2.5), 0.55, accent)


def ground(rng: Random, metre: Metre, low: int = 33) -> Bass:
    """A bass note where the chord begins, perhaps another in the middle of the bar or on each beat."""
    unit = "." * (metre.div - 1)
    whole, each = "X" + "." * (metre.beats * metre.div - 1), ("X" + unit) * metre.beats
    half = ("X" + unit + ("." + unit) * (metre.beats // 2 - 1)) * 2 if metre.beats % 2 == 0 else each
    return Bass(rng, [whole, whole, half, each], rng.choice(["root", "fifth", "octave"]), low, 1.0)


def slow_plan(rng: Random, seats: list[Seat], metre: Metre, bpm: float, timing: str = "") -> Plan:
    """A plan in a song's key; people play, some with rubato, a few to a machine's click."""
    found, lines = pop_key(rng)
    timing = timing or rng.choice(["human", "human", "human", "expressive", "machine"])
    drift = rng.uniform(0.015, 0.06) if timing == "expressive" else rng.uniform(0.006, 0.02)
    chords = harmony(rng, found, [*lines, *JAZZ[:3]] if found.scale == "major" else lines, rng.choice([0, 0.2]))
    return Plan(bpm, seats, chords, found, metre, timing=timing, drift=drift)


def sung(rng: Random, pace: float = 0.45) -> Seat:
    """A slow melody with pickups."""
    line = Melody(rng, 58, 80, rng.uniform(0.15, pace + 0.2), rng.uniform(0.1, 0.35), pickup=0.6)
    return Seat("lead", line, program(rng, "choir", "reeds", "violin", "flutes", "solo strings", "lead"))


@style("slow piano", "slow", 2.8)
def slow_piano(rng: Random) -> Plan:
    """Piano or electric piano: running broken chords over bass notes, with or without a voice, strings, a cello."""
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    keys = program(rng, "piano", "piano", "epiano", wild=0.01)
    seats = [Seat("arpeggio", running(rng, metre), keys), Seat("bass", ground(rng, metre), keys)]
    if rng.random() < 0.65:
        seats.append(sung(rng) if rng.random() < 0.6 else Seat("lead", Melody(rng, 64, 84, 0.35, 0.15), keys, 1.15))
    if rng.random() < 0.35:
        seats.append(Seat("pad", Pad(rng, 58), program(rng, "strings", "pad"), 0.6))
    return slow_plan(rng, seats, metre, rng.uniform(46, 78))


@style("slow guitar", "slow", 2.4)
def slow_guitar(rng: Random) -> Plan:
    """A picked or softly strummed guitar, a bass, a voice; perhaps a shaker in eighths."""
    metre = rng.choice([COMMON, COMMON, COMMON, THREE])
    picked: Player = running(rng, metre, 56)
    if rng.random() < 0.3:
        unit = rng.choice(["x.o.", "X.oo", "xoxo", "x..o"])
        picked = Comp(rng, [unit * metre.beats], 56, 4, 0.95, 0.02)
    seats = [Seat("comp", picked, program(rng, "nylon", "steel", "electric", "harp", wild=0))]
    if rng.random() < 0.6:
        seats.append(Seat("bass", ground(rng, metre, 30), program(rng, "bass", "upright", "nylon")))
    if rng.random() < 0.75:
        seats.append(sung(rng))
    if rng.random() < 0.25:
        lane = rng.choice(["x.o.", "xoxo", "..x.", "x..."]) * metre.beats
        seats.append(Seat("percussion", Percussion(rng, Groove({rng.choice(["shaker", "tamb"]): lane})), kit(rng)))
    return slow_plan(rng, seats, metre, rng.uniform(48, 78))


@style("slow strings", "slow", 2.0)
def slow_strings(rng: Random) -> Plan:
    """Strings, winds or a choir: repeated eighths or broken chords inside, long notes above and below."""
    metre = rng.choice([COMMON, COMMON, THREE, TWELVE])
    group = rng.choice(["strings", "strings", "pizzicato", "reeds", "brass", "harp"])
    unit = rng.choice(["x" * metre.div, "X" + "o" * (metre.div - 1), "x" + "." * (metre.div - 1)])
    inner = running(rng, metre) if rng.random() < 0.6 else Comp(rng, [unit * metre.beats], 60, 3, 0.8)
    seats = [
        Seat("comp", inner, program(rng, group, wild=0.02)),
        Seat("bass", ground(rng, metre, 36), program(rng, "strings", "solo strings", wild=0.02)),
    ]
    if rng.random() < 0.6:
        seats.append(Seat("pad", Pad(rng, 62, 3, 0.45), program(rng, "strings", "choir"), 0.7))
    if rng.random() < 0.7:
        seats.append(sung(rng, 0.3))
    return slow_plan(rng, seats, metre, rng.uniform(46, 76), rng.choice(["human", "expressive", "machine"]))


@style("one drop", "slow", 2.6)
def one_drop(rng: Random) -> Plan:
    """Slow reggae: kick and rim on two and four and none on one, chords on the off-beats, a bass that sings."""
    found = key(rng)
    hats = rng.choice(
        ["x.x.x.x.x.x.x.x.", "xoxoxoxoxoxoxoxo", "..x...x...x...x.", "x..ox..ox..ox..o", "X.x.X.x.X.x.X.x."]
    )
    drop = {"kick": "....X.......X...", rng.choice(["rim", "snare", "rim"]): "....X.......X...", "hat": hats}
    if rng.random() < 0.3:  # drums of the hills: heartbeats and a repeater
        drop = {"tom6": "X.x.....X.x.....", "conga": rng.choice(["....x.xx....x.x.", "..x.xx....x.x.xx"])}
    riff = [(0.0, 1.0), *[hit for hit in weave(rng, COMMON, 0.45, 2, 0.2) if hit[0] > 0]]
    skank = rng.choice(["..x...x...x...x.", "..xx..xx..xx..xx", "..x...x...x...xx"])
    seats = [
        Seat("bass", Figure(rng, riff, (0, 0, 3 if found.scale == "minor" else 4, 7, 12), 30), program(rng, "bass")),
        Seat("comp", Comp(rng, [skank], 60, 3, 0.3), program(rng, "electric", "organ", "piano")),
    ]
    if rng.random() < 0.85:
        seats.append(Seat("drums", Drummer(rng, Groove(drop), fills=0.4, crash=0.3, ride=0.1), kit(rng)))
    if rng.random() < 0.5:
        bubble = Comp(rng, [".x.x.x.x.x.x.x.x", ".xx..xx..xx..xx.", "..xo..xo..xo..xo"], 60, 3, 0.35)
        seats.append(Seat("comp2", bubble, program(rng, "organ"), 0.7))
    if rng.random() < 0.7:
        seats.append(sung(rng))
    chords = harmony(rng, found, LINES if found.scale == "major" else SAD)
    fine = rng.choice([0.5, 0.5, 0.58, 0.64])
    return Plan(rng.uniform(58, 79), seats, chords, found, swing_fine=fine, drift=0.01)


@style("slow soul", "slow", 2.4)
def slow_soul(rng: Random) -> Plan:
    """Soul and R&B: sixteenths on the hat, a soft rim or finger snap or none at all, electric piano, a free bass."""
    found = key(rng, "major", "minor", "dorian")
    soft = rng.choice(["....o.......o...", "....x.......x...", "............x...", "........x......."])
    lanes = {
        "kick": rng.choice(["X......x..x.....", "X..x......x..x..", "X.........x.....", "x.....x...x....."]),
        rng.choice(["hat", "shaker", "hat"]): rng.choice(["xoxoxoxoxoxoxoxo", "x.x.x.x.x.x.x.x.", "o-x-o-x-o-x-o-x-"]),
    }
    if rng.random() < 0.7:
        lanes[rng.choice(["rim", "snap", "clap", "stick"])] = soft
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), fills=0.3, crash=0.2), kit(rng, "standard", "brush", "808", "jazz")),
        Seat(
            "bass",
            Bass(rng, ["X.....xX..x.....", "X..x......x.x...", "X.........x..x..", "X......."], "fifth", 30),
            program(rng, "bass", "synth bass"),
        ),
        Seat(
            "comp",
            Comp(rng, ["X.......", "X..x....", "X.....x...x.....", "..x...x.", "x.x.x.x."], 60, 4, 0.9),
            program(rng, "epiano", "organ", "piano", "electric"),
        ),
    ]
    if rng.random() < 0.7:
        seats.append(sung(rng, 0.6))
    lines = [*MINOR, "im9 iv7", "im7 IV7"] if found.scale != "major" else [*POP, *JAZZ[:4]]
    chords = harmony(rng, found, lines, 0.15)
    fine = rng.choice([0.5, 0.5, 0.56, 0.62])
    return Plan(rng.uniform(54, 78), seats, chords, found, timing=rng.choice(["human", "machine"]), swing_fine=fine)


@style("slow six-eight", "slow", 2.6)
def slow_compound(rng: Random) -> Plan:
    """Six-eight and twelve-eight: triplets in piano, guitar or organ over slow beats; soft drums for some."""
    metre = rng.choice([JIG, TWELVE, TWELVE])
    seats = [
        Seat("arpeggio", running(rng, metre), program(rng, "piano", "nylon", "electric", "organ", "epiano", wild=0.01)),
        Seat("bass", ground(rng, metre), program(rng, "bass", "piano", "upright")),
    ]
    if rng.random() < 0.45:
        half = metre.beats // 2
        lanes = {rng.choice(["hat", "ride", "shaker"]): rng.choice(["xoo", "xxx", "x.x"]) * metre.beats}
        if rng.random() < 0.6:
            lanes["kick"] = rng.choice(["X.....", "X....x", "X..X.."]) * half
        if rng.random() < 0.5:
            lanes[rng.choice(["rim", "snare"])] = "...o.." * half
        seats.append(Seat("drums", Drummer(rng, Groove(lanes), fills=0.4, crash=0.3), kit(rng, "standard", "brush")))
    if rng.random() < 0.7:
        seats.append(sung(rng))
    return slow_plan(rng, seats, metre, rng.uniform(42, 70) if metre is JIG else rng.uniform(46, 76))


@style("lullaby", "slow", 1.0, held_out=True)
def lullaby(rng: Random) -> Plan:
    """A harp, a music box or a piano that rocks in eighths or triplets, one voice above."""
    metre = rng.choice([COMMON, COMMON, THREE, JIG])
    keys = program(rng, "harp", "music box", "piano", "nylon", "mallets", wild=0.02)
    seats = [Seat("arpeggio", running(rng, metre), keys), Seat("lead", Melody(rng, 64, 81, 0.25, 0.05), keys)]
    if rng.random() < 0.5:
        seats.append(Seat("bass", ground(rng, metre), program(rng, "strings", "upright", "piano")))
    return slow_plan(rng, seats, metre, rng.uniform(46, 76))


@style("dub", "slow", 1.0, held_out=True)
def dub(rng: Random) -> Plan:
    """Little more than bass and a drop on two and four; chords that come and go."""
    found = key(rng, "minor", "dorian")
    lanes = {
        "kick": "....X.......X...",
        "rim": rng.choice(["....X.......X...", "....X..x....X...", "............X..."]),
    }
    lanes["hat"] = rng.choice(["x.x.x.x.x.x.x.x.", "..x...x...x...x.", "x..ox..ox..ox..o"])
    riff = [(0.0, 1.0), *[hit for hit in weave(rng, COMMON, 0.4, 2, 0.3) if hit[0] > 0]]
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), fills=0.5, crash=0.2), kit(rng)),
        Seat("bass", Figure(rng, riff, (0, 0, 3, 7, 10), 28, palm=0.8), program(rng, "bass", "synth bass")),
        Seat("comp", Comp(rng, ["..x...x...x...x.", "..x.......x.....", "......x........."], 60, 3, 0.3), 27),
    ]
    return Plan(rng.uniform(58, 78), seats, harmony(rng, found, SAD), found, drift=0.008)
