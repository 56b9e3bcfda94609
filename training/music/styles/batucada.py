"""Brazil beside the bossa and samba bands: batucada, choro, guitar and voice, baião, maracatu."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat
from training.music.comping import Comp
from training.music.drums import Groove
from training.music.harmony import JAZZ, MINOR, POP, key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.piece import COMMON, TWO, Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.drums_alone import silent
from training.music.styles.rock import harmony

TAMBORIM = ["x.x.xx.x.x.x.xx.", ".x.x.xx.x.x.x.xx", "x.x.x.xx.x.x.xx.", "x..x..x.x..x.x..", "xx.x.xx.x.xx.x.x"]
PANDEIRO = ["X.oxx.oX", "xooXxooX", "x.oXx.oX", "XoxxXoxx"]
SHAKEN = ["XoxxXoxx", "xooxxoox", "XxxXXxxX", "xxxxxxxx"]


def two_bars(rng: Random, lanes: dict[str, str], drop: float = 0.04) -> Percussion:
    """A percussionist with lanes of two bars of two-four (those of one bar are played twice)."""
    return Percussion(rng, Groove({name: line * (16 // len(line)) for name, line in lanes.items()}, 2), drop)


def battery(rng: Random) -> dict[str, str]:
    """Low drum on two, an answer on one, sixteenths, tamborims in syncopation, bells: some of these."""
    lanes = {"surdo": rng.choice(["....X...", "o...X...", "....X..x", "x...X.x."])}
    if rng.random() < 0.6:
        lanes["surdo2"] = rng.choice(["x.......", "x......x", "x..x...."])
    more = {
        rng.choice(["shaker", "cabasa", "tamb"]): rng.choice(SHAKEN),
        rng.choice(["rim", "block1", "bongo1", "mute"]): rng.choice(TAMBORIM),
        "snare": rng.choice(["o-xoo-xo", "xo-xo-xo", "XooxoxoX", "-o-x-o-x"]),
    }
    for name in rng.sample(sorted(more), rng.randint(1, 3)):
        lanes[name] = more[name]
    if rng.random() < 0.4:
        high = rng.choice(["x.x..xx...x.x...", "x..x..x...x.x.x."])
        lanes["agogo1"] = high
        lanes["agogo2"] = "".join("x" if mark == "." and rng.random() < 0.3 else "." for mark in high)
    if rng.random() < 0.25:
        lanes["cuica1"] = rng.choice(["x..x.x..x..x.x..", "..x.x..x..x.x..x"])
    return lanes


@style("batucada", "timeline", 2.0)
def batucada(rng: Random) -> Plan:
    """Drums of a samba school, from two players to all."""
    found, chords = silent(rng)
    seats = [Seat("percussion", two_bars(rng, battery(rng), rng.uniform(0.0, 0.08)), kit(rng))]
    sections = [("a", 0.6, None), ("b", 0.9, None)]
    return Plan(rng.uniform(84, 138), seats, chords, found, TWO, drift=0.01, sections=sections)


@style("choro", "timeline", 1.3)
def choro(rng: Random) -> Plan:
    """Pandeiro, guitar with bass runs, a fast tune on flute, clarinet or mandolin; two-four."""
    found = key(rng, "major", "minor", "harmonic")
    comp = Comp(rng, ["..x.x..x", ".xx.xx.x", "x.xx.x.x", ".x.x.xx."], 62, 4, 0.4)
    seats = [
        Seat("comp", comp, program(rng, "nylon", "steel", wild=0)),
        Seat("bass", Bass(rng, ["X..xX...", "X...X.x.", "X...X..."], "scale", 36), program(rng, "nylon", "upright")),
        Seat("lead", Melody(rng, 62, 86, rng.uniform(0.7, 1.0), 0.2, 0.08), program(rng, "flutes", "reeds", "steel")),
    ]
    if rng.random() < 0.6:
        lanes = {rng.choice(["tamb", "shaker"]): rng.choice(PANDEIRO)}
        if rng.random() < 0.6:
            lanes["tom6"] = rng.choice(["....X...", "x...X..."])
        seats.append(Seat("percussion", two_bars(rng, lanes), kit(rng)))
    lines = POP if found.scale == "major" else [*MINOR, "i V7 i V7 iv i V7 i"]
    return Plan(rng.uniform(66, 118), seats, harmony(rng, found, lines, 0.2), found, TWO, drift=0.015)


@style("guitar and voice", "timeline", 1.8)
def guitar_and_voice(rng: Random) -> Plan:
    """Bossa nova without a band: the thumb on the beats, the fingers in a pattern of two bars; a voice, a shaker."""
    found = key(rng, "major", "minor")
    fingers = ["x.x..x.xx..x..x.", "x..x..x...x..x..", "..x..x.x..x.x..x", "x.x.x..xx.x..x..", ".x..x.x..x.x..x."]
    seats = [
        Seat("comp", Comp(rng, fingers, 60, 3, 0.7, bars=2, anticipate=rng.choice([0, 0.3])), program(rng, "nylon")),
        Seat("bass", Bass(rng, ["X...X...", "X..xX..x", "X..xX..."], "fifth", 36), program(rng, "nylon", "upright")),
    ]
    if rng.random() < 0.8:
        voice = program(rng, "choir", "flutes", "reeds", "solo brass", "piano")
        seats.append(Seat("lead", Melody(rng, 57, 78, 0.4, 0.45), voice))
    if rng.random() < 0.4:
        lanes = {rng.choice(["shaker", "hat", "cabasa"]): "xoxoxoxo"}
        if rng.random() < 0.6:
            lanes["rim"] = rng.choice(["x..x..x...x..x..", "..x.x...x..x..x."])
        seats.append(Seat("percussion", two_bars(rng, lanes), kit(rng, "brush", "standard")))
    chords = harmony(rng, found, JAZZ if found.scale == "major" else [*MINOR, "im7 iv7 iim7b5 V7"])
    return Plan(rng.triangular(96, 164, 128), seats, chords, found, COMMON, drift=0.012)


def northeast(rng: Random, lanes: dict[str, str], bpm: float, metre: Metre, drums_only: float) -> Plan:
    """A plan with accordion, pipes or viola in a mixolydian or dorian key; or the drums alone."""
    found = key(rng, "mixolydian", "major", "dorian")
    seats = [Seat("percussion", two_bars(rng, lanes), kit(rng))]
    if rng.random() > drums_only:
        seats += [
            Seat(
                "comp", Comp(rng, ["..x...x.", "x.xx.x.x", ".xx..xx."], 62, 3, 0.4), program(rng, "accordion", "nylon")
            ),
            Seat("lead", Melody(rng, 60, 82, 0.7, 0.3), program(rng, "accordion", "pipes", "choir", "flutes")),
        ]
        if rng.random() < 0.7:
            seats.append(Seat("bass", Bass(rng, ["X..x....", "X..xX.x.", "X..x..x."], "fifth"), program(rng, "bass")))
    lines = ["I bVII IV I", "I I bVII I", "I IV V I"] if found.scale != "dorian" else ["i IV", "i bVII i IV"]
    return Plan(bpm, seats, harmony(rng, found, lines), found, metre, drift=0.012)


@style("baiao", "timeline", 1.4)
def baiao(rng: Random) -> Plan:
    """The zabumba's long-short (three and one), a stick under it, the triangle in sixteenths."""
    lanes = {
        rng.choice(["surdo", "tom6", "kick"]): rng.choice(["X..x....", "X..X....", "X..x..x.", "X..X...x"]),
        rng.choice(["rim", "bongo1", "stick"]): rng.choice(["......x.", "....x.x.", "..x...x."]),
    }
    if rng.random() < 0.8:
        lanes["tri"] = rng.choice(["..X...X.", "ooXoooXo"])
        lanes["mutetri"] = "xx.xxx.x"
    return northeast(rng, lanes, rng.uniform(80, 134), TWO, 0.25)


@style("maracatu", "timeline", 1.0, held_out=True)
def maracatu(rng: Random) -> Plan:
    """Great drums in syncopation, a bell, a snare that rolls in sixteenths, shakers."""
    lanes = {
        rng.choice(["surdo", "tom6"]): rng.choice(["X..X..X.X..X....", "X...X..X..X.X...", ".X.XX..x.X.XX..."]),
        rng.choice(["agogo1", "cowbell"]): rng.choice(["x.xx.x.x.x.xx.x.", "x.x.x..xx.x.x.x.", ".x.x..xx.x.x..x."]),
        "snare": rng.choice(["xooXoxoo", "ooXooXox", "XooxoXoo"]),
    }
    if rng.random() < 0.6:
        lanes["cabasa"] = "XoxoXoxo"
    return northeast(rng, lanes, rng.uniform(82, 116), TWO, 0.6)
