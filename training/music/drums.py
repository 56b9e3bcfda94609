"""The drummer: grooves, their variation by section, fills, crashes, ghost notes."""

from dataclasses import dataclass, field
from random import Random

from training.music.form import Bar
from training.music.pattern import Lanes, Pattern, bar_of, parse
from training.music.piece import Note

KIT = {
    "kick": 36,
    "kick2": 35,
    "snare": 38,
    "snare2": 40,
    "rim": 37,
    "clap": 39,
    "hat": 42,
    "pedal": 44,
    "open": 46,
    "crash": 49,
    "crash2": 57,
    "ride": 51,
    "bell": 53,
    "ride2": 59,
    "china": 52,
    "splash": 55,
    "tom1": 50,
    "tom2": 48,
    "tom3": 47,
    "tom4": 45,
    "tom5": 43,
    "tom6": 41,
    "tamb": 54,
    "cowbell": 56,
    "vibra": 58,
    "bongo1": 60,
    "bongo2": 61,
    "mute": 62,
    "conga": 63,
    "conga2": 64,
    "timb1": 65,
    "timb2": 66,
    "agogo1": 67,
    "agogo2": 68,
    "cabasa": 69,
    "shaker": 70,
    "whistle": 71,
    "guiro": 73,
    "guiro2": 74,
    "claves": 75,
    "block1": 76,
    "block2": 77,
    "cuica1": 78,
    "cuica2": 79,
    "mutetri": 80,
    "tri": 81,
    "shaker2": 82,
    "bells": 83,
    "stick": 31,
    "slap": 28,
    "push": 29,
    "pull": 30,
    "roll": 25,
    "snap": 26,
    "surdo2": 87,
    "surdo": 86,
}


@dataclass(slots=True)
class Groove:
    """Lanes of steps over some bars; the hat's lane is moved to ride or crash in loud sections."""

    lanes: Lanes
    bars: int = 1
    time: str = "hat"  # the drum that keeps the time

    def hits(self, beats: int) -> dict[str, Pattern]:
        return {drum: parse(line, beats * self.bars) for drum, line in self.lanes.items()}


@dataclass(slots=True)
class Drummer:
    """Plays grooves by section: `verse`, `chorus`; fills at phrase ends; a crash where a section begins."""

    rng: Random
    verse: Groove
    chorus: Groove | None = None
    fill_every: int = 4
    fills: float = 0.7
    crash: float = 0.8
    drop: float = 0.05
    ghosts: float = 0.0
    ride: float = 0.5
    free: float = 0.0  # chance that a bar is played otherwise than written
    name: str = "drums"
    remap: dict[str, str] = field(default_factory=dict)
    _told: dict[str, dict[str, str]] = field(default_factory=dict)

    def play(self, bar: Bar) -> list[Note]:
        rng, beats = self.rng, bar.metre.beats
        loud = bar.energy > 0.68
        groove = self.chorus if loud and self.chorus is not None else self.verse
        names = self._names(bar, loud, groove)
        filled = float(beats)
        notes: list[Note] = []
        if bar.phrase_end(self.fill_every) and rng.random() < self.fills:
            notes, filled = self._fill(bar)
        for drum, pattern in groove.hits(beats).items():
            for at, level in bar_of(pattern, bar.place, groove.bars, beats):
                keep = drum in ("kick", "snare") and level > 0.5
                if at < filled - 1e-6 and rng.random() > (self.drop if not keep else self.drop * 0.2):
                    notes.append(_hit(names.get(drum, drum), at, level))
        if rng.random() < self.free:
            notes = self._loosen(bar, notes, filled)
        if self.ghosts and filled == beats:
            for step in range(beats * 4):
                if step % 4 and rng.random() < self.ghosts:
                    notes.append(_hit("snare", step / 4, rng.uniform(0.18, 0.36)))
        if (bar.place == 0 and rng.random() < self.crash * (0.3 + bar.energy)) or rng.random() < 0.02:
            notes.append(_hit(rng.choice(["crash", "crash", "crash2", "splash", "china"]), 0.0, 1.0))
        return notes

    def _loosen(self, bar: Bar, notes: list[Note], until: float) -> list[Note]:
        """Some hits less, others more: kicks and ghosts between, open hats before beats, a snare moved."""
        rng, grid = self.rng, bar.metre.div * 2
        kept = [note for note in notes if note.start == 0 or rng.random() > 0.12 or note.velocity > 0.9]
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(max(1, round(until * grid))) / grid
            drum = rng.choice(["kick", "kick", "snare", "snare", "open", "tom5", "tom2"])
            strong = bar.metre.strength(at) >= 2
            if drum == "snare" and strong:
                continue
            loud = rng.uniform(0.55, 0.9) if drum != "snare" or rng.random() < 0.3 else rng.uniform(0.2, 0.4)
            kept.append(_hit(drum, at, loud))
        return kept

    def _names(self, bar: Bar, loud: bool, groove: Groove) -> dict[str, str]:
        label = bar.section.label + str(loud)
        if label not in self._told:
            told = dict(self.remap)
            if loud and self.rng.random() < self.ride:
                told[groove.time] = self.rng.choice(["ride", "open", "bell", "crash", "ride", "china"])
            self._told[label] = told
        return self._told[label]

    def _fill(self, bar: Bar) -> tuple[list[Note], float]:
        """A fill over the last beat, two, or the whole bar; the groove goes on before it."""
        rng, beats = self.rng, bar.metre.beats
        span = min(beats, rng.choice([1, 1, 1, 2, 2, 0.5, beats] if not bar.closing else [1, 2, 2, beats, beats]))
        start = beats - span
        if rng.random() < 0.12:  # a rest instead of a fill
            return ([_hit("snare", start, 0.9)] if rng.random() < 0.5 else []), start
        div = bar.metre.div * (2 if bar.metre.div == 2 else rng.choice([1, 1, 2]))
        if rng.random() < 0.15 and bar.metre.div == 2:
            div = rng.choice([3, 6, 2])
        drums = rng.choice(
            [
                ["snare"],
                ["snare", "tom1", "tom3", "tom5"],
                ["tom1", "tom2", "tom4", "tom6"],
                ["snare", "kick"],
                ["snare", "snare", "tom5", "kick"],
                ["tom5", "kick", "snare", "hat"],
            ]
        )
        count = max(1, round(span * div))
        gap = rng.choice([0.0, 0.1, 0.3, 0.45])
        notes = []
        for step in range(count):
            if step and rng.random() < gap:
                continue
            drum = drums[min(len(drums) - 1, step * len(drums) // count)] if rng.random() < 0.85 else rng.choice(drums)
            notes.append(_hit(drum, start + step / div, 0.6 + 0.35 * step / count + rng.uniform(-0.1, 0.1)))
        if rng.random() < 0.5:
            notes += [_hit("kick", start + beat, 0.7) for beat in range(int(span))]
        return notes, start


def _hit(drum: str, at: float, level: float) -> Note:
    return Note(at, 0.2, KIT[drum], level)
