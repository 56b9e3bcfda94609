"""Five, seven, nine and eleven in a bar: rock, Balkan dances, jazz, minimal patterns, songs, film strings.

Every eighth (or quarter) of the bar that the musicians count is a beat; the groups of two and three are accents.
"""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import Drummer, Groove
from training.music.figure import Figure
from training.music.harmony import JAZZ, MINOR, POP, ROCK, key
from training.music.melody import Melody
from training.music.pattern import weave
from training.music.percussion import Percussion
from training.music.piece import Metre
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony

Groups = tuple[int, ...]

FIVES: list[Groups] = [(3, 2), (3, 2), (2, 3)]
SEVENS: list[Groups] = [(2, 2, 3), (3, 2, 2), (4, 3), (2, 3, 2), (3, 4)]
NINES: list[Groups] = [(2, 2, 2, 3), (2, 2, 2, 3), (3, 2, 2, 2), (5, 4)]
SIXES: list[Groups] = [(4, 2), (3, 3), (2, 2, 2)]


def metre_of(groups: Groups) -> Metre:
    """The metre whose strong beats begin these groups."""
    return Metre(sum(groups), 2, tuple(sum(groups[:index]) for index in range(1, len(groups))))


def line(groups: Groups, first: str, others: str, last: str = "") -> str:
    """A bar: `first` begins the first group, `others` the next ones, `last` the last; each has the steps of a beat."""
    steps = len(first)
    marks = [first, *[others] * (len(groups) - 1)]
    if last and len(groups) > 1:
        marks[-1] = last
    return "".join(mark + "." * steps * (size - 1) for mark, size in zip(marks, groups, strict=True))


def kit_lanes(rng: Random, groups: Groups, quick: bool) -> dict[str, str]:
    """Kick and snare on the groups, the hat on beats or between; one more kick for some."""
    rest = "." if quick else "..."
    beats = sum(groups)
    weak = rng.random() < 0.4
    kick = list(line(groups, "X" + rest, "x" + rest if weak else "." + rest, "." + rest))
    for _ in range(rng.choice([0, 1, 1, 2])):
        at = rng.randrange(1, len(kick), 1 if quick else 2)
        kick[at] = "x"
    snare = line(groups, "." + rest, "X" + rest if not weak or len(groups) == 2 else "." + rest, "X" + rest)
    time = rng.choice(["xo"] if quick else ["x.x.", "x...", "xoxo", "x.o."])
    if quick and rng.random() < 0.6:
        time = "x."
    return {"kick": "".join(kick), "snare": snare, rng.choice(["hat", "hat", "ride"]): time * beats}


def riff_of(rng: Random, groups: Groups, fine: int) -> list[tuple[float, float]]:
    """The rhythm of a riff: hits where the groups begin, others between."""
    metre = metre_of(groups)
    hits = dict(weave(rng, metre, rng.uniform(0.3, 0.8), fine, 0.6))
    hits |= {0.0: 1.0, **{float(at): 0.9 for at in metre.groups if rng.random() < 0.85}}
    return sorted(hits.items())


def draw(rng: Random, *, quick: float = 0.4) -> tuple[Groups, float, bool]:
    """Groups, tempo of the counted beats, and whether these are eighths."""
    groups = rng.choice(rng.choice([FIVES, SEVENS, SEVENS, NINES, SIXES]))
    fast = rng.random() < quick
    return groups, rng.uniform(150, 212) if fast else rng.uniform(86, 168), fast


@style("odd rock", "odd", 2.2)
def odd_rock(rng: Random) -> Plan:
    """A band with a riff: guitar, bass, drums that mark the groups; a voice for some."""
    groups, bpm, quick = draw(rng)
    found = key(rng, "minor", "dorian", "mixolydian", "phrygian")
    pattern = riff_of(rng, groups, 1)
    guitar = Figure(rng, pattern, (0, 0, 3, 5, 7, 10), 40, power=rng.random() < 0.5)
    verse, chorus = (Groove(kit_lanes(rng, groups, quick)) for _ in range(2))
    seats = [
        Seat("drums", Drummer(rng, verse, chorus, ghosts=0.0 if quick else rng.choice([0, 0.06])), kit(rng)),
        Seat("comp", guitar, program(rng, "distorted", "electric", "organ", "epiano")),
        Seat("bass", Figure(rng, pattern, (0, 0, 0, 7, 10), 28), program(rng, "bass", "synth bass")),
    ]
    if rng.random() < 0.5:
        seats.append(Seat("lead", Melody(rng, 58, 80, 0.4, 0.15), program(rng, "choir", "lead", "distorted", "organ")))
    chords = harmony(rng, found, ["i i bVII i", "i i i i", *MINOR[:4], *ROCK[6:8]])
    return Plan(bpm, seats, chords, found, metre_of(groups), drift=0.01, lengths=(4, 4, 8))


def balkan(rng: Random, groups: Groups, bpm: float) -> Plan:
    """A dance: the great drum on the groups, the stick between, accordion, strings or pipes in running notes."""
    found = key(rng, "hijaz", "dorian", "minor", "harmonic", "major", "phrygian")
    beats = sum(groups)
    low = line(groups, "X.", "x.", rng.choice(["x.", "X."]))
    high = "".join(rng.choice(["..", "o.", "o.", "oo"]) if low[2 * at] == "." else ".." for at in range(beats))
    chop = "".join(("." if low[2 * at] != "." else "x") + "." for at in range(beats))
    drums = {rng.choice(["tom6", "kick", "surdo"]): low, rng.choice(["rim", "stick", "tamb", "bongo1"]): high}
    lead = Melody(rng, 60, 84, rng.uniform(0.5, 0.85), 0.05, 0.05, 0.3, ornaments=rng.choice([0, 0.1, 0.2]))
    lines = {"major": ["I V", "I IV V I", "I I V V"], "hijaz": ["I bII I bII", "I I bII I", "I iv I I"]}
    chords = harmony(rng, found, lines.get(found.scale, ["i bVII", "i iv i i", "i i bVII i", "i V i i"]))
    seats = [Seat("lead", lead, program(rng, "accordion", "reeds", "violin", "pipes", "ethnic", "solo brass"))]
    if rng.random() < 0.8:
        seats.append(Seat("percussion", Percussion(rng, Groove(drums), 0.04), kit(rng)))
    if rng.random() < 0.75 or len(seats) == 1:
        seats.append(Seat("bass", Bass(rng, [low], "fifth", 33), program(rng, "bass", "tuba", "accordion", "upright")))
        seats.append(Seat("comp", Comp(rng, [chop, low], 62, 3, 0.4), program(rng, "accordion", "nylon", "brass")))
    return Plan(bpm, seats, chords, found, metre_of(groups), drift=0.012, lengths=(4, 8, 8))


@style("balkan dance", "odd", 2.0)
def balkan_dance(rng: Random) -> Plan:
    """Seven as 3+2+2 or 2+2+3, nine as 2+2+2+3, five as 2+3; the eighths are the beats."""
    groups = rng.choice([(3, 2, 2), (2, 2, 3), (2, 2, 3), (2, 2, 2, 3), (2, 2, 2, 3), (2, 3)])
    return balkan(rng, groups, rng.uniform(136, 212))


@style("kopanitsa", "odd", 0.8, held_out=True)
def kopanitsa(rng: Random) -> Plan:
    """Eleven, and slow songs in seven and five."""
    if rng.random() < 0.35:
        return balkan(rng, (2, 2, 3, 2, 2), rng.uniform(170, 212))
    return balkan(rng, rng.choice([(3, 2, 2), (3, 2), (2, 2, 3)]), rng.uniform(100, 170))


@style("odd jazz", "odd", 1.7)
def odd_jazz(rng: Random) -> Plan:
    """Five, seven and nine with a ride, a vamp of piano and bass, a solo; swung or straight."""
    groups = rng.choice([*FIVES, *FIVES, (4, 3), (3, 4), (2, 2, 3), (5, 4)])
    found = key(rng, "minor", "dorian", "major")
    rides = "".join(rng.choice(["X...", "X.x."]) for _ in range(sum(groups)))
    lanes = {"ride": rides, "pedal": line(groups, "....", "x...", "x...")}
    if rng.random() < 0.6:
        lanes["kick"] = line(groups, "o...", "o...")
    if rng.random() < 0.6:
        lanes["snare"] = "".join(rng.choice("......-o.") if step % 2 == 0 else "." for step in range(4 * sum(groups)))
    vamp = riff_of(rng, groups, 1)
    seats = [
        Seat("drums", Drummer(rng, Groove(lanes, time="ride"), None, 8, 0.4, 0.3), kit(rng, "jazz", "brush")),
        Seat("bass", Figure(rng, vamp, (0, 7, 10, 12, 5), 31, palm=0.9), program(rng, "upright", "bass")),
        Seat("comp", Comp(rng, [line(groups, "x.", "x."), line(groups, "X.", ".x"), ""], 60, 4, 0.6), 0),
    ]
    if rng.random() < 0.7:
        seats.append(
            Seat("lead", Melody(rng, 58, 82, 0.5, 0.3), program(rng, "reeds", "solo brass", "piano", "flutes"))
        )
    chords = harmony(rng, found, JAZZ if found.scale == "major" else ["im7 iv7", "im7 im7 bVI7 V7", "im7 IV7"])
    swing = rng.choice([0.5, rng.uniform(0.57, 0.66)])
    return Plan(rng.uniform(96, 196), seats, chords, found, metre_of(groups), swing=swing, drift=0.015)


@style("odd minimal", "odd", 1.6)
def odd_minimal(rng: Random) -> Plan:
    """Machines: patterns of five, seven or nine notes or beats over a pulse, a bass on the groups, few drums."""
    groups, bpm, quick = draw(rng, quick=0.5)
    found = key(rng, "minor", "dorian", "lydian", "major")
    beats = sum(groups)
    rate = 1 if quick and rng.random() < 0.5 else rng.choice([2, 2, 4]) if not quick else 2
    shape = tuple([0] + [rng.randrange(0, 5) for _ in range(beats * rate - 1)])
    accents = rng.uniform(0.0, 0.3)
    seats = [
        Seat(
            "arpeggio", Arpeggio(rng, rate, shape, 64, 3, 0.8, 0.58, accents), program(rng, "lead", "mallets", "bells")
        ),
        Seat("bass", Bass(rng, [line(groups, "X.", "x."), line(groups, "X.", "..", "x.")], "root", 30), 38),
    ]
    if rng.random() < 0.6:
        lanes = {"kick": rng.choice(["X...", "X..."]) * beats if rng.random() < 0.5 else line(groups, "X...", "x...")}
        lanes[rng.choice(["hat", "shaker", "rim"])] = rng.choice(["..x.", "x.x.", "x..."]) * beats
        seats.append(Seat("drums", Percussion(rng, Groove(lanes)), kit(rng, "808", "electronic", "standard")))
    if rng.random() < 0.4:
        seats.append(Seat("pad", Pad(rng, 58, 3), program(rng, "pad", "strings", "choir"), 0.6))
    chords = harmony(rng, found, POP if found.scale in ("major", "lydian") else MINOR)
    return Plan(bpm, seats, chords, found, metre_of(groups), timing="machine", lengths=(4, 8, 8))


@style("odd song", "odd", 1.6)
def odd_song(rng: Random) -> Plan:
    """Guitar or piano in five, six, seven or nine quarters, a voice, soft drums for some."""
    groups = rng.choice([*FIVES, (4, 3), (2, 2, 3), (4, 2), (3, 3), (5, 4)])
    found = key(rng, "major", "minor")
    metre = metre_of(groups)
    figure = Arpeggio(rng, rng.choice([2, 2, 1, 4]), None, 58, 4, 1.2, 0.55, 0.2)
    strum = Comp(rng, [line(groups, "X.", "x."), line(groups, "X.x.", "x.xo"), "x." * metre.beats], 58, 4, 0.9, 0.015)
    seats = [
        Seat("comp", either(rng, figure, strum), program(rng, "nylon", "steel", "piano", "epiano", wild=0.01)),
        Seat(
            "bass", Bass(rng, [line(groups, "X.", "x."), line(groups, "X.", "..")], "fifth", 33), program(rng, "bass")
        ),
    ]
    if rng.random() < 0.75:
        seats.append(Seat("lead", Melody(rng, 58, 79, 0.4, 0.15), program(rng, "choir", "reeds", "flutes", "violin")))
    if rng.random() < 0.4:
        seats.append(Seat("drums", Drummer(rng, Groove(kit_lanes(rng, groups, False))), kit(rng, "brush", "standard")))
    chords = harmony(rng, found, POP if found.scale == "major" else MINOR)
    return Plan(rng.uniform(68, 140), seats, chords, found, metre, drift=0.015)


@style("odd film", "odd", 0.8, held_out=True)
def odd_film(rng: Random) -> Plan:
    """Strings in ostinatos of five and seven, low drums on the groups, brass chords."""
    groups = rng.choice([*FIVES, *SEVENS, (2, 2, 2, 3)])
    found = key(rng, "minor", "phrygian", "dorian")
    figure = Figure(rng, riff_of(rng, groups, 1), (0, 0, 3, 7, 12), 48, palm=0.6)
    seats = [Seat("comp", figure, 48), Seat("pad", Pad(rng, 52, 3), program(rng, "brass", "strings", "choir"), 0.7)]
    if rng.random() < 0.6:
        drums = Percussion(rng, Groove({"tom6": line(groups, "X.", "x."), "tom5": line(groups, "..", ".o")}))
        seats.append(Seat("drums", drums, kit(rng, "orchestra", "standard")))
    return Plan(rng.uniform(110, 205), seats, harmony(rng, found, MINOR), found, metre_of(groups), drift=0.01)
