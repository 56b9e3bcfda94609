"""A player of hand drums, and the cycles of tabla, darbuka and djembe."""

from random import Random

from training.music.form import Bar
from training.music.pattern import parse
from training.music.piece import COMMON, TWELVE, TWO, Metre, Note
from training.music.programs import kit


class Strokes:
    """Two or three sounds of hand drums; a cycle, with variations of whole bars in double time and rolls."""

    def __init__(self, rng: Random, low: str, high: str, fill: float = 0.15) -> None:
        """`low` and `high` are the lines of a bar; they may be played on drums of a kit or on a tuned drum."""
        self.rng, self.fill = rng, fill
        self.low, self.high = low, high
        self.tuned = rng.random() < 0.4
        base = rng.randint(40, 52)
        kits = rng.choice(
            [
                (61, 60, 60),
                (64, 63, 62),
                (41, 48, 37),
                (43, 50, 76),
                (64, 60, 77),
                (45, 60, 75),
                (36, 60, 62),
                (66, 65, 37),
            ]
        )
        self.pitches = (base, base + rng.randint(7, 14), base + rng.randint(12, 20)) if self.tuned else kits

    def program(self) -> int:
        """A tuned drum, or the kit."""
        return self.rng.choice([115, 116, 117, 118, 116, 117, 47]) if self.tuned else kit(self.rng)

    def play(self, bar: Bar) -> list[Note]:
        rng, beats = self.rng, bar.metre.beats
        notes = [Note(at, 0.3, self.pitches[0], level) for at, level in parse(self.low, beats)]
        for at, level in parse(self.high, beats):
            notes.append(Note(at, 0.3, self.pitches[1 if level > 0.7 else 2], level))
        if (bar.phrase_end(rng.choice([2, 4, 4])) and rng.random() < 0.5) or rng.random() < self.fill:
            start = rng.choice([0.0, beats / 2, beats - 1.0])
            notes = [note for note in notes if note.start < start or note.start == 0]
            step = 1 / (bar.metre.div * 2 if bar.metre.div == 2 else rng.choice([3, 6]))
            at = start
            while at < beats - 1e-6:
                if rng.random() < 0.8:
                    level = 0.85 if abs(at - round(at)) < 1e-6 else rng.uniform(0.4, 0.75)
                    notes.append(Note(at, 0.3, rng.choice(self.pitches), level))
                at += step
        return [note for note in notes if rng.random() > 0.03]


TABLA = [  # bass (ge), treble (na, tin); metre
    ("X.x.....|....x.x.", "xoxxxoxo|xoxxxoxo", COMMON),
    ("X...x.........x.", "x.x.x.x.x.x.x.x.", COMMON),
    ("x.x.x.x...x.x.x.", "xxxxxxxxxxxxxxxx", COMMON),
    ("Xx....x.", "xxoxxxox", COMMON),
    ("X.....x.", "..xxx.xx", COMMON),
    ("Xx..x.", "xxoxxo", Metre(2, 3)),
    ("X.....", "xoxxox", Metre(2, 3)),
    ("X..xx.", ".xx..x", Metre(2, 3)),
    ("X..x..x.", "xoxxoxxo", COMMON),
    ("X...X...", "x.xxx.xx", TWO),
]


DARBUKA = [
    ("X...x...", ".x.x..x.", COMMON),
    ("X..XX...", ".x....x.", COMMON),
    ("XX..X...", "...x..x.", COMMON),
    ("X..x..x.", "..x..x.x", TWO),
    ("X...X.x.", "..xx...x", TWO),
    ("X.......", "..x..xx.", COMMON),
    ("X..x....", "......x.", TWO),
    ("X...X...", "-.x--.x-", TWO),
    ("X..x..X.", ".xx.xx.x", COMMON),
]


DJEMBE = [
    ("X.....X.....", "..xx.x..xx.x", TWELVE),
    ("X..X..X..X..", ".xx.xx.xx.xx", TWELVE),
    ("X..x..x.X..x..x.", "..x..x...xx..x.x", COMMON),
    ("X.......X.......", "..xx..xx..xx..xx", COMMON),
    ("X.x...x.X.x...x.", "...xx..x...xx..x", COMMON),
    ("X.....x.....", ".xxx.x.xxx.x", TWELVE),
]


def drums_of(rng: Random, cycles: list[tuple[str, str, Metre]]) -> tuple[Strokes, Metre]:
    """A player of one of these cycles, slightly changed."""
    low, high, metre = rng.choice(cycles)
    low, high = low.replace("|", ""), high.replace("|", "")
    changed = "".join("o" if mark == "." and rng.random() < 0.12 else mark for mark in high)
    return Strokes(rng, low, changed, rng.uniform(0.02, 0.25)), metre
