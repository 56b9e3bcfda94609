"""Keys, chords, progressions and their voicings."""

import re
from dataclasses import dataclass
from random import Random

SCALES = {
    "major": (0, 2, 4, 5, 7, 9, 11), "minor": (0, 2, 3, 5, 7, 8, 10), "harmonic": (0, 2, 3, 5, 7, 8, 11),
    "dorian": (0, 2, 3, 5, 7, 9, 10), "phrygian": (0, 1, 3, 5, 7, 8, 10), "lydian": (0, 2, 4, 6, 7, 9, 11),
    "mixolydian": (0, 2, 4, 5, 7, 9, 10), "hijaz": (0, 1, 4, 5, 7, 8, 10), "pentatonic": (0, 2, 4, 7, 9),
    "minor pentatonic": (0, 3, 5, 7, 10), "blues": (0, 3, 5, 6, 7, 10), "pelog": (0, 1, 3, 7, 8),
    "slendro": (0, 2, 5, 7, 9), "whole": (0, 2, 4, 6, 8, 10), "bhairav": (0, 1, 4, 5, 7, 8, 11),
}  # fmt: skip

QUALITIES = {
    "": (0, 4, 7), "m": (0, 3, 7), "7": (0, 4, 7, 10), "maj7": (0, 4, 7, 11), "m7": (0, 3, 7, 10),
    "5": (0, 7, 12), "sus4": (0, 5, 7), "sus2": (0, 2, 7), "6": (0, 4, 7, 9), "m6": (0, 3, 7, 9),
    "dim": (0, 3, 6), "dim7": (0, 3, 6, 9), "m7b5": (0, 3, 6, 10), "aug": (0, 4, 8), "9": (0, 4, 7, 10, 14),
    "add9": (0, 4, 7, 14), "m9": (0, 3, 7, 10, 14), "7sus4": (0, 5, 7, 10),
}  # fmt: skip

_DEGREES = {"i": 0, "ii": 2, "iii": 4, "iv": 5, "v": 7, "vi": 9, "vii": 11}
_SYMBOL = re.compile(r"^([b#]?)([ivIV]+)([^/]*)(?:/([b#]?[ivIV]+))?$")


@dataclass(frozen=True, slots=True)
class Chord:
    """Pitch class of root and bass, and the intervals above the root."""

    root: int
    intervals: tuple[int, ...]
    bass: int

    @property
    def classes(self) -> tuple[int, ...]:
        return tuple(dict.fromkeys((self.root + step) % 12 for step in self.intervals))


@dataclass(frozen=True, slots=True)
class Key:
    """Tonic pitch class and scale."""

    tonic: int
    scale: str

    @property
    def classes(self) -> tuple[int, ...]:
        return tuple((self.tonic + step) % 12 for step in SCALES[self.scale])

    def ladder(self, low: int, high: int) -> list[int]:
        """All pitches of the scale from low to high."""
        inside = set(self.classes)
        return [pitch for pitch in range(low, high + 1) if pitch % 12 in inside]

    def chord(self, symbol: str) -> Chord:
        """The chord of a Roman numeral: `bVII`, `ii7`, `V/vii`; lower case: minor; after a slash the bass, a degree."""
        match = _SYMBOL.match(symbol)
        if match is None:
            raise ValueError(symbol)
        shift, numeral, quality, bass = match.groups()
        root = (self.tonic + _degree(shift + numeral)) % 12
        small = numeral.islower() and quality in ("", "7", "6", "9")
        intervals = QUALITIES["m" + quality if small else quality]
        return Chord(root, intervals, (self.tonic + _degree(bass)) % 12 if bass else root)


def _degree(numeral: str) -> int:
    shift = {"b": -1, "#": 1}.get(numeral[0], 0)
    return _DEGREES[numeral.lstrip("b#").lower()] + shift


def key(rng: Random, *scales: str) -> Key:
    """A key on any tonic, in one of these scales."""
    return Key(rng.randrange(12), rng.choice(scales or ("major", "minor")))


def progression(
    rng: Random, key: Key, lines: list[str], bars: int, split: float = 0.0
) -> list[list[tuple[float, Chord]]]:
    """So many bars of one of these lines repeated; `IV,V` is two chords in one bar; places are shares of the bar."""
    bits = rng.choice(lines).split()
    slow = rng.random() < 0.15 and len(bits) <= 4 and bars >= 2 * len(bits)
    rows = []
    for bar in range(bars):
        names = bits[(bar // 2 if slow else bar) % len(bits)].split(",")
        chords = [(place / len(names), key.chord(name)) for place, name in enumerate(names)]
        if len(names) == 1 and rng.random() < split:
            chords.append((0.5, key.chord(rng.choice(bits).split(",")[0])))
        rows.append(chords)
    return rows


def voicing(chord: Chord, centre: int, count: int = 3, previous: list[int] | None = None) -> list[int]:
    """Close position about a pitch; with a previous voicing its average is the centre, so that voices move little."""
    middle = centre
    if previous:
        middle = round(0.6 * sum(previous) / len(previous) + 0.4 * centre)
    classes = [chord.classes[index % len(chord.classes)] for index in range(count)]
    found: list[int] = []
    for index, name in enumerate(classes):
        pitch = middle + ((name - middle + 6) % 12) - 6
        if index >= len(chord.classes):
            pitch += 12 if pitch < middle else -12
        found.append(pitch)
    return sorted(set(found))


def nearest(pitch_class: int, pitch: int) -> int:
    """The pitch of this class nearest to a pitch."""
    return pitch + ((pitch_class - pitch + 6) % 12) - 6


POP = [
    "I V vi IV", "vi IV I V", "I vi IV V", "I IV V IV", "IV I V vi", "I IV vi V", "I iii IV V", "I V IV IV",
    "I I IV V", "vi V IV V", "IV V vi I", "ii V I I", "I IV I V", "I ii IV V", "I bVII IV I", "iii vi ii V",
    "I V/vii vi IV", "Iadd9 Vsus4 vi7 IVmaj7", "I iv I V", "IV iv I I", "I,V vi,IV I,V IV", "I ii iii IV",
]  # fmt: skip
MINOR = [
    "i bVI bIII bVII", "i bVII bVI V", "i iv bVII bIII", "i bVI iv V", "i i iv V", "i bVII i bVII", "i v bVI bVII",
    "i bIII bVII iv", "i bVI bVII i", "i iv i V", "i bVII bVI bVII", "bVI bVII i i", "i iim7b5 V i",
]  # fmt: skip
ROCK = [
    "I bVII IV I", "I IV bVII IV", "I I bIII IV", "i bIII bVII IV", "I IV I V", "I bVI bVII I", "i bVII bVI bVII",
    "I I IV I", "i i bVII IV", "I V IV I", "bVI bVII I I",
]  # fmt: skip
BLUES = ["I7 I7 I7 I7 IV7 IV7 I7 I7 V7 IV7 I7 V7", "I7 IV7 I7 I7 IV7 IV7 I7 I7 V7 IV7 I7 V7",
         "i7 i7 i7 i7 iv7 iv7 i7 i7 bVI7 V7 i7 V7"]  # fmt: skip
JAZZ = [
    "iim7 V7 Imaj7 vim7", "Imaj7 vi7 ii7 V7", "ii7 V7 Imaj7 Imaj7", "iim7b5 V7 im7 im7",
    "Imaj7 IVmaj7 iii7 vi7 ii7 V7 Imaj7 V7",
    "iii7,vi7 ii7,V7 Imaj7 Imaj7", "Imaj7,vi7 ii7,V7 iii7,vi7 ii7,V7", "im7 IV7 im7 IV7",
]  # fmt: skip
CLASSICAL = [
    "I V7 I V7 I IV V7 I", "I I V7 V7 V7 V7 I I", "I IV V7 I", "I vi ii V7 I IV I,V7 I", "I V vi iii IV I IV V7",
    "I ii V7 I", "I,IV I,V7 I V7,I", "I I IV I V7 V7 I I",
]  # fmt: skip
CLASSICAL_MINOR = ["i V7 i V7 i iv V7 i", "i iv V7 i", "i bVI iim7b5 V7 i iv i,V7 i", "i bVII bIII bVI iv i V7 i"]
