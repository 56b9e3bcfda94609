"""Fault injection for a show in virtual time: seeded schedule of faults, their effects, and edits of the patch file."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from live.control.events.events import BeatHeard, ControlEvent, RestartAudio, SourceChanged
from live.control.osc.osc_codec import OscRejected, decode
from live.rehearse.simulated_band import FakeBand
from live.rehearse.simulated_players import HOSTILE, Call
from live.show.patch.patch_search_path import MAIN_FILE

FAULT_SALT: Final = 0xFA17
KINDS: Final = {
    "source lost": 0.10, "stall": 0.15, "flood": 0.08, "garbage": 0.10, "good edit": 0.20, "bad edit": 0.15,
    "edit back": 0.05, "tempo jump": 0.10, "impossible beats": 0.08, "device again": 0.05, "other source": 0.08,
    "crowd of calls": 0.05, "rest": 0.05,
}  # fmt: skip
"""Kinds of faults, and their rates per minute."""


class Fault(NamedTuple):
    """One fault."""

    time: float
    """When [s of the show]."""
    kind: str
    size: float
    """Severity, 0 to 1."""


def faults(seed: int, *, rate: float = 1.0, start: float = 20.0) -> Iterator[Fault]:
    """Yield faults in order of time, endlessly; `rate`: factor of the rates in KINDS."""
    if rate <= 0.0:
        return
    chance = np.random.default_rng([seed, FAULT_SALT])
    names = list(KINDS)
    shares = np.array([KINDS[name] for name in names])
    each, time = 60.0 / (rate * float(shares.sum())), start
    while True:
        time += float(chance.exponential(each))
        name = names[int(chance.choice(len(names), p=shares / shares.sum()))]
        yield Fault(time, name, float(chance.random()))


EDIT_SALT: Final = 0xED17
GOOD: Final = (
    '[[formation]]\nname = "rehearsed {n}"\nshape = "circle"\nsize = [{a:.2f}, {a:.2f}]\n',
    '[[view]]\nname = "seen {n}"\neye = [{a:.2f}, 3.0, 10.0]\ntarget = [0.0, 0.9, 0.0]\n',
    '[[looks]]\nname = "dusk {n}"\nkey_light = [1.0, {b:.2f}, 0.2]\nmeasures = 1\n',
    '[[scene]]\nname = "low {n}"\nmeasures = 2\n[scene.set]\n"/dance/light/level" = {b:.2f}\n',
    '[[scene]]\nname = "wide {n}"\n[scene.set]\n"/dance/motion/larger" = {b:.2f}\n'
    '[[cue]]\nname = "wide {n}"\nscene = "wide {n}"\ncount_in = 4\n',
    '[[react]]\nto = "loudness"\nsets = "larger"\nlow = 0.0\nhigh = {b:.2f}\n',
    '[[signal]]\nname = "heard {n}"\n[[react]]\non = "heard {n}"\ncall = "/dance/spread"\nvalues = [2]\n',
    '[[element]]\nkind = "attract"\nmeasure = 1\nmeasures = 2\nat = [{a:.2f}, 0.0]\nstrength = 0.5\n',
    '[[at]]\nmeasure = 2\nbeat = 2.5\ncall = "/dance/light/level"\nvalues = [{b:.2f}, 1]\n',
)
"""Tables that are valid in any patch; n: a number, a: 1 to 4, b: 0.1 to 0.4."""
BAD: Final = (
    "[[element]\n", "loop_measures = -3\n", '[[group]]\nname = "x"\n', '[[segment]]\nmeasure = 1\nmeasures = -2\n',
    '[[sequence]]\nmeasure = 1\nsteps = ["no such step"]\n', "\x00\x01\x02", "[stage]\nwidth = nan\n", "ünïcode ¤ = =",
    '[[cue]]\nname = "a"\nscene = "nowhere"\n', "[locomotion]\nthreshold_m = 1e-9\n", "[" * 3000,
)  # fmt: skip
"""Invalid additions to a patch."""


class Edits:
    """Edits of a copy of a patch while the show runs: valid, invalid, and back to the original."""

    def __init__(self, path: Path, folder: Path, seed: int) -> None:
        """`path`: the patch, which is not changed."""
        self._chance = np.random.default_rng([seed, EDIT_SALT])
        if path.name == MAIN_FILE:
            shutil.copytree(path.parent, folder, dirs_exist_ok=True)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, folder / path.name)
        self.path = folder / path.name
        """The copy."""
        self._text = self.path.read_text(encoding="utf-8")
        self.saved = {"good": 0, "bad": 0, "back": 0}
        """Number of edits by kind."""

    def good(self) -> None:
        """Save a valid edit."""
        chance = self._chance
        number, size, share = int(chance.integers(100)), chance.uniform(1.0, 4.0), chance.uniform(0.1, 0.4)
        table = GOOD[int(chance.integers(len(GOOD)))].format(n=number, a=float(size), b=float(share))
        self._save("good", f"{self._text}\n{table}")

    def bad(self) -> None:
        """Save an invalid edit."""
        chance = self._chance
        which = int(chance.integers(len(BAD) + 1))
        if which == len(BAD):
            self._save("bad", self._text[: int(chance.integers(len(self._text)))] + "\n[[")
        else:
            self._save("bad", f"{self._text}\n{BAD[which]}")

    def back(self) -> None:
        """Save the original."""
        self._save("back", self._text)

    def _save(self, kind: str, text: str) -> None:
        self.saved[kind] += 1
        self.path.write_text(text, encoding="utf-8")


FLOOD: Final = 6000
"""Events of the largest flood: more than the event queue holds."""


class Mishaps:
    """Executes faults in one soak test. The soak test has to apply `stands_for` and `deaf_until`."""

    def __init__(
        self,
        *,
        put: Callable[[ControlEvent], Any],
        call: Callable[[Call], None],
        refuse: Callable[[str], None],
        calls: Iterator[Call],
        edits: Edits,
        band: FakeBand,
        beats_per_measure: int,
        chance: np.random.Generator,
    ) -> None:
        """`put` accepts events, `call` calls, `refuse` counts invalid packets; `calls`: the players' calls."""
        self._put, self._call, self._refuse, self._calls = put, call, refuse, calls
        self._edits, self._band, self._beats, self._chance = edits, band, beats_per_measure, chance
        self.done: dict[str, int] = {}
        """Number of faults by kind."""
        self.stands_for = 0.0
        """Stall before the next frame [s]; the reader resets it to 0."""
        self.deaf_until = 0.0
        """Until this time [s of the show] no music is detected."""

    def do(self, fault: Fault) -> None:
        """Execute a fault."""
        self.done[fault.kind] = self.done.get(fault.kind, 0) + 1
        FAULTS[fault.kind](self, fault)

    def lose_source(self, fault: Fault) -> None:
        """The audio source is lost for up to a minute."""
        self.deaf_until = fault.time + 2.0 + 60.0 * fault.size
        for time, state in ((fault.time, "lost"), (self.deaf_until, "found")):
            self._put(SourceChanged(time=time, source="audio", state=state))

    def stall(self, fault: Fault) -> None:
        """The machine stalls: mostly for a moment, rarely for half a minute."""
        self.stands_for = 0.3 + 3.0 * fault.size + (30.0 if fault.size > 0.97 else 0.0)

    def flood(self, fault: Fault) -> None:
        """Up to thousands of messages arrive at once."""
        for number in range(int(FLOOD * fault.size)):
            x = -4.0 + 8.0 * (number % 97) / 97.0
            self._call(Call(fault.time, "/dance/attract", [x, fault.size, 1.0, 1.0], "osc"))

    def crowd_of_calls(self, fault: Fault) -> None:
        """Calls of all players from several minutes arrive within a frame."""
        for call, _ in zip(self._calls, range(int(200 * fault.size)), strict=False):
            self._call(Call(fault.time, call.address, call.values, call.source))
        # these calls are consumed from the players' stream: the next ones come only after their scheduled times

    def garbage(self, fault: Fault) -> None:
        """Invalid OSC packets arrive."""
        for _ in range(20):
            packet = self._chance.bytes(int(self._chance.integers(1, 400)))
            try:
                for message in decode(b"/dance/" + packet if fault.size > 0.5 else packet):
                    self._call(Call(fault.time, message.address, list(message.arguments), "osc"))
            except OscRejected:
                self._refuse("garbage")

    def jump_tempo(self, fault: Fault) -> None:
        """The band jumps to another tempo, and a tempo, half or double call arrives."""
        bpm = 60.0 + 120.0 * fault.size
        if fault.size < 0.5:
            self._call(Call(fault.time, "/dance/clock/tempo", [bpm], "osc"))
        else:
            self._call(Call(fault.time, "/dance/clock/half" if fault.size < 0.75 else "/dance/clock/double", [], "osc"))
        self._band.bpm = bpm

    def impossible(self, fault: Fault) -> None:
        """A source sends impossible beats."""
        for value in HOSTILE:
            if isinstance(value, float | int):
                number = float(value)
                self._put(
                    BeatHeard(time=fault.time, source="midi", beat_time=number, period=fault.size, confidence=1.0)
                )
                self._put(
                    BeatHeard(time=fault.time, source="midi", beat_time=fault.time, period=number, confidence=number)
                )

    def other_source(self, fault: Fault) -> None:
        """Another clock sends its own beat grid for a while; then a source is chosen."""
        period, source = 0.35 + 0.5 * fault.size, "midi"
        self._put(SourceChanged(time=fault.time, source=source, state="started"))
        for beat in range(16):
            time = fault.time + 0.001 * beat
            self._put(
                BeatHeard(
                    time=time,
                    source=source,
                    beat_time=fault.time + beat * period,
                    period=period,
                    confidence=0.9,
                    beat=beat % 4,
                    beats_per_measure=4,
                    measure=beat // 4,
                    jump=beat == 0,
                )
            )
        choice = ("midi", "auto", "internal", "audio")[int(fault.size * 4.0) % 4]
        self._call(Call(fault.time, "/dance/clock/source", [choice], "osc"))

    def restart_device(self, fault: Fault) -> None:
        """The audio device is opened again."""
        self._put(RestartAudio(time=fault.time, source="key"))

    def rest(self, fault: Fault) -> None:
        """Controls are reset, so that the effects of calls do not accumulate for ever."""
        for address, values in (
            ("/dance/clear", []), ("/dance/blackout", [0]), ("/dance/hold", [0]), ("/dance/hold/score", [0]),
            ("/dance/practice", []), ("/dance/clock/hold", [0]), ("/dance/clock/source", ["auto"]),
            ("/dance/clock/metre", [self._beats]), ("/dance/clock/tempo", [self._band.bpm]),
        ):  # fmt: skip
            self._call(Call(fault.time, address, list(values), "osc"))


FAULTS: Final[dict[str, Callable[[Mishaps, Fault], None]]] = {
    "source lost": Mishaps.lose_source,
    "stall": Mishaps.stall,
    "flood": Mishaps.flood,
    "garbage": Mishaps.garbage,
    "good edit": lambda mishaps, fault: mishaps._edits.good(),
    "bad edit": lambda mishaps, fault: mishaps._edits.bad(),
    "edit back": lambda mishaps, fault: mishaps._edits.back(),
    "tempo jump": Mishaps.jump_tempo,
    "impossible beats": Mishaps.impossible,
    "device again": Mishaps.restart_device,
    "other source": Mishaps.other_source,
    "crowd of calls": Mishaps.crowd_of_calls,
    "rest": Mishaps.rest,
}
"""Handlers by kind of fault."""
