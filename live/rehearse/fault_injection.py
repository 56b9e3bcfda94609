"""Fault injection for a show in virtual time: seeded schedule of faults, their effects, and edits of the patch file."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from live.control.events.events import BeatHeard, ControlEvent, RestartAudio, SourceChanged
from live.control.osc.osc_codec import OscRejected, decode
from live.rehearse.simulated_band import SimulatedBand
from live.rehearse.simulated_players import HOSTILE_VALUES, Call
from live.show.patch.patch_search_path import MAIN_FILE

FAULT_SALT: Final = 0xFA17
FAULT_RATES: Final = {
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
    severity: float
    """Severity, 0 to 1."""


def fault_schedule(seed: int, *, rate: float = 1.0, start: float = 20.0) -> Iterator[Fault]:
    """Yield faults in order of time, endlessly; `rate`: factor of the rates in KINDS."""
    if rate <= 0.0:
        return
    chance = np.random.default_rng([seed, FAULT_SALT])
    names = list(FAULT_RATES)
    shares = np.array([FAULT_RATES[name] for name in names])
    each, time = 60.0 / (rate * float(shares.sum())), start
    while True:
        time += float(chance.exponential(each))
        name = names[int(chance.choice(len(names), p=shares / shares.sum()))]
        yield Fault(time, name, float(chance.random()))


EDIT_SALT: Final = 0xED17
VALID_TABLES: Final = (
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
INVALID_TABLES: Final = (
    "[[element]\n", "loop_measures = -3\n", '[[group]]\nname = "x"\n', '[[segment]]\nmeasure = 1\nmeasures = -2\n',
    '[[sequence]]\nmeasure = 1\nsteps = ["no such step"]\n', "\x00\x01\x02", "[stage]\nwidth = nan\n", "ünïcode ¤ = =",
    '[[cue]]\nname = "a"\nscene = "nowhere"\n', "[locomotion]\nthreshold_m = 1e-9\n", "[" * 3000,
)  # fmt: skip
"""Invalid additions to a patch."""


class PatchEditor:
    """Edits of a copy of a patch while the show runs: valid, invalid, and back to the original."""

    def __init__(self, path: Path, folder: Path, seed: int) -> None:
        """`path`: the patch, which is not changed."""
        self._rng = np.random.default_rng([seed, EDIT_SALT])
        if path.name == MAIN_FILE:
            shutil.copytree(path.parent, folder, dirs_exist_ok=True)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, folder / path.name)
        self.path = folder / path.name
        """The copy."""
        self._text = self.path.read_text(encoding="utf-8")
        self.edit_counts = {"good": 0, "bad": 0, "back": 0}
        """Number of edits by kind."""

    def save_valid(self) -> None:
        """Save a valid edit."""
        chance = self._rng
        number, size, share = int(chance.integers(100)), chance.uniform(1.0, 4.0), chance.uniform(0.1, 0.4)
        table = VALID_TABLES[int(chance.integers(len(VALID_TABLES)))].format(n=number, a=float(size), b=float(share))
        self._save("good", f"{self._text}\n{table}")

    def save_invalid(self) -> None:
        """Save an invalid edit."""
        chance = self._rng
        which = int(chance.integers(len(INVALID_TABLES) + 1))
        if which == len(INVALID_TABLES):
            self._save("bad", self._text[: int(chance.integers(len(self._text)))] + "\n[[")
        else:
            self._save("bad", f"{self._text}\n{INVALID_TABLES[which]}")

    def restore(self) -> None:
        """Save the original."""
        self._save("back", self._text)

    def _save(self, kind: str, text: str) -> None:
        self.edit_counts[kind] += 1
        self.path.write_text(text, encoding="utf-8")


FLOOD_EVENTS: Final = 6000
"""Events of the largest flood: more than the event queue holds."""


class FaultInjector:
    """Executes faults in one soak test. The soak test has to apply `stall_seconds` and `deaf_until`."""

    def __init__(
        self,
        *,
        put: Callable[[ControlEvent], Any],
        call: Callable[[Call], None],
        refuse: Callable[[str], None],
        calls: Iterator[Call],
        edits: PatchEditor,
        band: SimulatedBand,
        beats_per_measure: int,
        chance: np.random.Generator,
    ) -> None:
        """`put` accepts events, `call` calls, `refuse` counts invalid packets; `calls`: the players' calls."""
        self._put, self._call, self._refuse, self._calls = put, call, refuse, calls
        self._edits, self._band, self._beats, self._rng = edits, band, beats_per_measure, chance
        self.counts: dict[str, int] = {}
        """Number of faults by kind."""
        self.stall_seconds = 0.0
        """Stall before the next frame [s]; the reader resets it to 0."""
        self.deaf_until = 0.0
        """Until this time [s of the show] no music is detected."""

    def execute(self, fault: Fault) -> None:
        """Execute a fault."""
        self.counts[fault.kind] = self.counts.get(fault.kind, 0) + 1
        FAULT_HANDLERS[fault.kind](self, fault)

    def lose_source(self, fault: Fault) -> None:
        """The audio source is lost for up to a minute."""
        self.deaf_until = fault.time + 2.0 + 60.0 * fault.severity
        for time, state in ((fault.time, "lost"), (self.deaf_until, "found")):
            self._put(SourceChanged(time=time, source="audio", state=state))

    def stall(self, fault: Fault) -> None:
        """The machine stalls: mostly for a moment, rarely for half a minute."""
        self.stall_seconds = 0.3 + 3.0 * fault.severity + (30.0 if fault.severity > 0.97 else 0.0)

    def send_flood(self, fault: Fault) -> None:
        """Up to thousands of messages arrive at once."""
        for number in range(int(FLOOD_EVENTS * fault.severity)):
            x = -4.0 + 8.0 * (number % 97) / 97.0
            self._call(Call(fault.time, "/dance/attract", [x, fault.severity, 1.0, 1.0], "osc"))

    def send_call_burst(self, fault: Fault) -> None:
        """Calls of all players from several minutes arrive within a frame."""
        for call, _ in zip(self._calls, range(int(200 * fault.severity)), strict=False):
            self._call(Call(fault.time, call.address, call.values, call.source))
        # these calls are consumed from the players' stream: the next ones come only after their scheduled times

    def send_garbage(self, fault: Fault) -> None:
        """Invalid OSC packets arrive."""
        for _ in range(20):
            packet = self._rng.bytes(int(self._rng.integers(1, 400)))
            try:
                for message in decode(b"/dance/" + packet if fault.severity > 0.5 else packet):
                    self._call(Call(fault.time, message.address, list(message.arguments), "osc"))
            except OscRejected:
                self._refuse("garbage")

    def jump_tempo(self, fault: Fault) -> None:
        """The band jumps to another tempo, and a tempo, half or double call arrives."""
        bpm = 60.0 + 120.0 * fault.severity
        if fault.severity < 0.5:
            self._call(Call(fault.time, "/dance/clock/tempo", [bpm], "osc"))
        else:
            self._call(
                Call(fault.time, "/dance/clock/half" if fault.severity < 0.75 else "/dance/clock/double", [], "osc")
            )
        self._band.bpm = bpm

    def send_impossible_beats(self, fault: Fault) -> None:
        """A source sends impossible beats."""
        for value in HOSTILE_VALUES:
            if isinstance(value, float | int):
                number = float(value)
                self._put(
                    BeatHeard(time=fault.time, source="midi", beat_time=number, period=fault.severity, confidence=1.0)
                )
                self._put(
                    BeatHeard(time=fault.time, source="midi", beat_time=fault.time, period=number, confidence=number)
                )

    def send_other_source(self, fault: Fault) -> None:
        """Another clock sends its own beat grid for a while; then a source is chosen."""
        period, source = 0.35 + 0.5 * fault.severity, "midi"
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
        choice = ("midi", "auto", "internal", "audio")[int(fault.severity * 4.0) % 4]
        self._call(Call(fault.time, "/dance/clock/source", [choice], "osc"))

    def restart_device(self, fault: Fault) -> None:
        """The audio device is opened again."""
        self._put(RestartAudio(time=fault.time, source="key"))

    def reset_controls(self, fault: Fault) -> None:
        """Controls are reset, so that the effects of calls do not accumulate for ever."""
        for address, values in (
            ("/dance/clear", []), ("/dance/blackout", [0]), ("/dance/hold", [0]), ("/dance/hold/score", [0]),
            ("/dance/practice", []), ("/dance/clock/hold", [0]), ("/dance/clock/source", ["auto"]),
            ("/dance/clock/metre", [self._beats]), ("/dance/clock/tempo", [self._band.bpm]),
        ):  # fmt: skip
            self._call(Call(fault.time, address, list(values), "osc"))


FAULT_HANDLERS: Final[dict[str, Callable[[FaultInjector, Fault], None]]] = {
    "source lost": FaultInjector.lose_source,
    "stall": FaultInjector.stall,
    "flood": FaultInjector.send_flood,
    "garbage": FaultInjector.send_garbage,
    "good edit": lambda mishaps, fault: mishaps._edits.save_valid(),
    "bad edit": lambda mishaps, fault: mishaps._edits.save_invalid(),
    "edit back": lambda mishaps, fault: mishaps._edits.restore(),
    "tempo jump": FaultInjector.jump_tempo,
    "impossible beats": FaultInjector.send_impossible_beats,
    "device again": FaultInjector.restart_device,
    "other source": FaultInjector.send_other_source,
    "crowd of calls": FaultInjector.send_call_burst,
    "rest": FaultInjector.reset_controls,
}
"""Handlers by kind of fault."""
