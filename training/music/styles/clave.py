"""Cuban music with its timelines: claves alone, with one other instrument, rumba, cáscara and bells, songo.

A measure holds the whole clave: four beats, the pulse of the dancers' steps.
"""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Player, Seat, either
from training.music.comping import Arpeggio, Comp
from training.music.drums import Drummer, Groove
from training.music.harmony import key
from training.music.melody import Melody
from training.music.percussion import Percussion
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.drums_alone import silent
from training.music.styles.rock import harmony

SON, RUMBA = "x..x..x...x.x...", "x..x...x..x.x..."
CLAVE_SOUNDS = ["claves", "claves", "claves", "rim", "block1", "block2", "cowbell", "stick", "clap"]
CASCARA = "x.xx.xx.x.xx.x.x"
TUMBAO = {"conga2": "......xx......xx", "conga": "-.-.--..-.-.--..", "mute": "..X.......X....."}
BASS = ["...x..x....x..x.", "...x..x....x..x.", "x..x..x....x..x.", "X..x..x.X..x..x."]
MONTUNO = ["x.xx.x.xx.xx.x.x", "x.x.xx.x.x.x.xx.", "x.x..x.xx.x..x.x", "xx.xx.x.x.xx.xx."]
MAJOR_LINES = ["I IV V IV", "ii V", "I,IV V,IV", "I V V I", "I,ii V,ii"]
MINOR_LINES = ["i iv V", "i V V i", "i,iv V,iv", "i bVII bVI V", "i V"]


def turned(line: str) -> str:
    """The line from its middle on: 2-3 for 3-2."""
    half = len(line) // 2
    return line[half:] + line[:half]


def clave(rng: Random, line: str = "") -> tuple[str, bool]:
    """A clave and whether its three-side comes first."""
    line = line or rng.choice([SON, SON, SON, RUMBA, "x..x..x...x..x.."])
    three = rng.random() < 0.55
    return (line if three else turned(line)), three


def sticks(rng: Random, line: str) -> Seat:
    """One who plays the clave, seldom leaving out a hit."""
    lanes = {rng.choice(CLAVE_SOUNDS): line.replace("x", "X")}
    return Seat("percussion", Percussion(rng, Groove(lanes), rng.choice([0.0, 0.0, 0.02])), kit(rng))


def cuban(rng: Random, seats: list[Seat], bpm: float = 0.0) -> Plan:
    """A plan with the harmony of son and salsa."""
    found = key(rng, "major", "minor", "dorian")
    chords = harmony(rng, found, MAJOR_LINES if found.scale == "major" else MINOR_LINES)
    return Plan(bpm or rng.uniform(76, 114), seats, chords, found, timing=rng.choice(["human", "human", "machine"]))


@style("clave alone", "timeline", 1.8)
def clave_alone(rng: Random) -> Plan:
    """Nothing but the sticks. The three-side is taken for the beginning; where it is not, nobody could know."""
    line, three = clave(rng)
    found, chords = silent(rng)
    machine = rng.random() < 0.3
    return Plan(
        rng.uniform(64, 116),
        [sticks(rng, line)],
        chords,
        found,
        timing="machine" if machine else "human",
        drift=0.012,
        has_downbeat=three,
        sections=[("a", 0.7, None)],
    )


@style("clave and one more", "timeline", 2.2)
def clave_and_one(rng: Random) -> Plan:
    """The sticks with congas, maracas, a bell, a bass, a piano's montuno, or a tune."""
    line, _ = clave(rng)
    voice = Melody(rng, 58, 80, 0.5, 0.35, silence=0.05)
    maracas = {rng.choice(["shaker", "cabasa", "guiro2"]): rng.choice(["x.xxx.xxx.xxx.xx", "xxxxxxxxxxxxxxxx"])}
    bell = {rng.choice(["cowbell", "timb1", "agogo1"]): rng.choice([CASCARA, "X.x.X.xxX.x.X.xx", "X...X...X...X..."])}
    pairs: list[tuple[Player, int]] = [
        (Percussion(rng, Groove(TUMBAO), 0.05), kit(rng)),
        (Percussion(rng, Groove(maracas), 0.03), kit(rng)),
        (Percussion(rng, Groove(bell), 0.03), kit(rng)),
        (Bass(rng, BASS, "fifth", 30, 1.0), program(rng, "bass", "upright")),
        (Comp(rng, MONTUNO, 66, 3, 0.5), program(rng, "piano", "nylon", "steel")),
        (voice, program(rng, "choir", "reeds", "solo brass", "flutes", "piano")),
    ]
    player, number = rng.choice(pairs)
    return cuban(rng, [sticks(rng, line), Seat("second", player, number)])


@style("rumba", "timeline", 1.6)
def rumba(rng: Random) -> Plan:
    """Rumba clave, sticks on wood, two congas that talk and one that improvises, a singer for some."""
    line, three = clave(rng, RUMBA)
    wood = CASCARA if three else turned(CASCARA)
    lanes = {
        "claves": line,
        rng.choice(["block2", "stick", "rim"]): wood,
        "conga2": rng.choice(["......X.......X.", "......X.....X.X."]),
        "conga": rng.choice(["..x.....x.x.....", "x..x......x..x.."]),
    }
    if rng.random() < 0.6:
        lanes["bongo1"] = "".join(rng.choice("..xo") for _ in range(16))
    if rng.random() < 0.3:
        del lanes["claves"]
    seats = [Seat("percussion", Percussion(rng, Groove(lanes), 0.07), kit(rng))]
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 57, 76, 0.5, 0.4), program(rng, "choir", "reeds", wild=0.02)))
    return cuban(rng, seats, rng.uniform(84, 124))


@style("cascara", "timeline", 1.6)
def cascara(rng: Random) -> Plan:
    """A band led by timbales and bells; the clave is felt more than heard. Montuno, tumbao, horns."""
    line, three = clave(rng, SON)
    shell = CASCARA if three else turned(CASCARA)
    lanes = {rng.choice(["timb1", "rim", "block1"]): shell, **TUMBAO}
    loud = {"cowbell": rng.choice(["X.x.X.x.X.x.X.x.", "X.xxX.xxX.xxX.xx"]), "timb2": "....x.......x...", **TUMBAO}
    if rng.random() < 0.5:
        lanes["claves"] = line
    montuno = rng.choice(MONTUNO)
    figure = either(rng, Comp(rng, [montuno], 66, 3, 0.5), Arpeggio(rng, 4, (0, 2, 1, 3), 66, 3, gaps=0.25))
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes), Groove(loud), fills=0.3, crash=0.3), kit(rng)),
        Seat("bass", Bass(rng, BASS, "fifth", 30, 1.0), program(rng, "bass", "upright")),
        Seat("comp", figure, program(rng, "piano", "nylon", "epiano")),
    ]
    if rng.random() < 0.6:
        seats.append(Seat("lead", Melody(rng, 58, 80, 0.6, 0.4), program(rng, "choir", "solo brass", "flutes")))
    if rng.random() < 0.4:
        stabs = Comp(rng, ["x..x..x.........", "..x.x...x..x....", "......x...x.x..."], 66, 3, 0.4)
        seats.append(Seat("brass", stabs, program(rng, "brass", "solo brass")))
    return cuban(rng, seats)


@style("songo", "timeline", 1.0, held_out=True)
def songo(rng: Random) -> Plan:
    """A kit that plays what congas and bells play, with the bass ahead of the beat."""
    line, _ = clave(rng, rng.choice([SON, RUMBA]))
    lanes = {
        rng.choice(["block1", "cowbell"]): "X.x.X.x.X.x.X.x.",
        "kick": "...x..x....x..x.",
        "snare": rng.choice(["....x..o....x..o", "..X.............", "..X..oo...X..oo."]),
        rng.choice(["tom3", "tom5"]): "......xx......xx",
    }
    if rng.random() < 0.5:
        lanes["rim"] = line
    seats = [Seat("drums", Drummer(rng, Groove(lanes), fills=0.4, crash=0.3), kit(rng))]
    if rng.random() < 0.75:
        seats.append(Seat("bass", Bass(rng, BASS, "fifth", 30, 1.0), program(rng, "bass")))
        seats.append(Seat("comp", Comp(rng, MONTUNO, 66, 3, 0.5), program(rng, "piano", "epiano")))
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 58, 80, 0.6, 0.4), program(rng, "choir", "solo brass")))
    return cuban(rng, seats)
