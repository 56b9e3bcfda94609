"""Random grammars: periodic patterns drawn by metrical weight, so that nothing but the metre is to be learnt."""

from random import Random

from training.music.bass import Bass
from training.music.build import Plan, Player, Seat, either
from training.music.comping import Arpeggio, Comp, Pad
from training.music.drums import KIT
from training.music.figure import Figure
from training.music.form import Bar, layers, song
from training.music.harmony import MINOR, POP, key
from training.music.melody import Melody
from training.music.pattern import Pattern, bar_of, weave
from training.music.piece import COMMON, JIG, THREE, TWELVE, TWO, Metre, Note
from training.music.programs import kit, program
from training.music.registry import style
from training.music.styles.rock import harmony

LOW = ["kick", "kick2", "tom6", "surdo", "tom5", "conga2", "push"]
HIGH = ["snare", "snare2", "rim", "clap", "conga", "block1", "tom1", "timb1", "slap", "bongo1", "stick"]
TIME = ["hat", "ride", "shaker", "tamb", "cabasa", "open", "bell", "cowbell", "claves", "tri", "block2"]


class Woven:
    """Drums of random patterns over one or two bars, varied seldom."""

    def __init__(self, rng: Random, metre: Metre, bpm: float = 110.0) -> None:
        self.rng = rng
        self.bars = rng.choice([1, 1, 2])
        fine = grid(rng, bpm)
        wide = Metre(metre.beats, metre.div)
        self.lanes: dict[str, Pattern] = {}
        for drum, density, bias in (
            (rng.choice(LOW), rng.uniform(0.25, 0.7), rng.uniform(0.6, 1.0)),
            (rng.choice(HIGH), rng.uniform(0.15, 0.5), rng.uniform(-0.8, 0.6)),
            (rng.choice(TIME), rng.uniform(0.5, 1.2), rng.uniform(0.0, 1.0)),
        ):
            hits: Pattern = []
            first = weave(rng, wide, density, fine, bias)
            for bar in range(self.bars):
                again = first if bar == 0 or rng.random() < 0.5 else weave(rng, wide, density, fine, bias)
                hits += [(at + bar * metre.beats, level) for at, level in again]
            self.lanes[drum] = hits
        if rng.random() < 0.8:  # somebody says where one is
            low = next(iter(self.lanes))
            if not any(at == 0 for at, _ in self.lanes[low]):
                self.lanes[low].insert(0, (0.0, 0.95))

    def play(self, bar: Bar) -> list[Note]:
        beats = bar.metre.beats
        notes = [
            Note(at, 0.2, KIT[drum], level)
            for drum, pattern in self.lanes.items()
            for at, level in bar_of(pattern, bar.place, self.bars, beats)
            if self.rng.random() > 0.04
        ]
        if bar.place == 0 and self.rng.random() < 0.5:
            notes.append(Note(0.0, 0.2, KIT["crash"], 0.9))
        return notes


def grid(rng: Random, bpm: float) -> int:
    """Steps per part of the beat: sixteenths where it is slow, eighths where it is fast; so the level can be told."""
    return 2 if rng.random() < min(1.0, max(0.0, (150 - bpm) / 60)) else 1


def random_plan(rng: Random, metre: Metre, mean: float = 110.0) -> Plan:
    """A band of random patterns in this metre, at tempi about this mean."""
    bpm = min(205.0, max(48.0, rng.gauss(mean, 0.25 * mean)))
    found = key(rng, "major", "minor", "dorian", "mixolydian", "phrygian", "pentatonic")
    seats = []
    if rng.random() < 0.85:
        seats.append(
            Seat("drums", Woven(rng, metre, bpm), kit(rng, "standard", "room", "electronic", "808", "jazz", "power"))
        )
    if rng.random() < 0.3:
        seats.append(Seat("percussion", Woven(rng, metre, bpm), kit(rng)))
    if rng.random() < 0.75:
        seats.append(
            Seat(
                "bass",
                Bass(
                    rng, [], rng.choice(["root", "root", "fifth", "octave", "arpeggio", "scale"]), grain=grid(rng, bpm)
                ),
                program(rng, "bass", "synth bass", "upright", wild=0.2),
            )
        )
    for turn in range(rng.choice([0, 1, 1, 2])):
        player = either(
            rng,
            Comp(rng, [], rng.randint(50, 70), rng.randint(2, 4), rng.uniform(0.3, 1.0), grain=grid(rng, bpm)),
            Arpeggio(
                rng,
                rng.choice([1, 2, 2, 3] if bpm > 125 else [1, 2, 2, 4, 4, 3]),
                centre=rng.randint(50, 74),
                voices=rng.randint(2, 4),
            ),
            Pad(rng, rng.randint(50, 68)),
            Figure(rng, weave(rng, metre, rng.uniform(0.3, 0.7), grid(rng, bpm)), low=rng.choice([36, 40, 48, 60])),
        )
        seats.append(
            Seat(
                f"comp{turn}",
                player,
                program(rng, "piano", "electric", "mallets", "pad", "organ", "lead", wild=0.4),
                0.8,
            )
        )
    if rng.random() < 0.5 or not seats:
        seats.append(
            Seat(
                "lead",
                Melody(rng, 58, 84, rng.uniform(0.1, 0.9 if bpm < 125 else 0.5), rng.uniform(0, 0.4)),
                program(rng, "lead", "flutes", wild=0.5),
            )
        )
    minor = found.scale in ("minor", "dorian", "phrygian")
    roles = [seat.role for seat in seats]
    return Plan(
        bpm,
        seats,
        harmony(rng, found, MINOR if minor else POP),
        found,
        metre,
        timing=rng.choice(["machine", "human", "human"]),
        drift=rng.uniform(0.004, 0.03),
        sections=layers(rng, roles) if rng.random() < 0.4 else song(rng, roles),
        swing=rng.choice([0.5, 0.5, 0.5, 0.5, rng.uniform(0.52, 0.68)]) if metre.div == 2 else 0.5,
    )


@style("random in three", "grammar", 1.0)
def random_three(rng: Random) -> Plan:
    return random_plan(rng, THREE)


@style("random in two", "grammar", 0.4)
def random_two(rng: Random) -> Plan:
    return random_plan(rng, TWO)


@style("random compound", "grammar", 0.8)
def random_compound(rng: Random) -> Plan:
    return random_plan(rng, rng.choice([JIG, TWELVE, TWELVE]), 96)


@style("random groove", "grammar", 2.5)
def random_groove(rng: Random) -> Plan:
    return random_plan(rng, COMMON)


@style("odd metre", "electronic", 0.35)
def odd(rng: Random) -> Plan:
    """Five and seven quarters, six with a middle: seldom."""
    metre = rng.choice([Metre(5, 2, (3,)), Metre(7, 2, (4,)), Metre(6, 2, (3,)), Metre(6, 2, (3,))])
    return random_plan(rng, metre)


@style("one instrument", "grammar", 1.2)
def one_instrument(rng: Random) -> Plan:
    """Nothing but a bass, a melody, an arpeggio, a strum or a riff: what is left when the band stops."""
    found = key(rng)
    metre = rng.choice([COMMON, COMMON, THREE])
    pairs: list[tuple[Player, str]] = [
        (Bass(rng, [], rng.choice(["root", "arpeggio", "scale", "octave"])), "bass"),
        (Melody(rng, 58, 84, rng.uniform(0.2, 0.8), 0.1, 0.08, 0.5, silence=0), "lead"),
        (Arpeggio(rng, rng.choice([2, 2, 3, 4]), None, 60, 4), "piano"),
        (Comp(rng, [], 58, 4, 0.8), "electric"),
        (Figure(rng, [(0.0, 1.0), *[hit for hit in weave(rng, metre, 0.6) if hit[0] > 0]], low=40), "electric"),
    ]
    player, family = rng.choice(pairs)
    lines = POP if found.scale == "major" else MINOR
    return Plan(
        rng.triangular(58, 180, 108),
        [Seat("lead", player, program(rng, family, wild=0.4))],
        harmony(rng, found, lines, 0.1),
        found,
        metre,
        timing=rng.choice(["human", "machine", "expressive"]),
        drift=0.02,
        sections=[("a", 0.7, None), ("b", 0.7, None)],
    )
