"""Orders: what the supervisor is told when it is made, and what it reports."""

import socket
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from live.supervisor.network.identity import Identity, Pairings


@dataclass(frozen=True, slots=True)
class Orders:
    """Which processes make a show. A command gets the numbers of two more descriptors as its last arguments."""

    engine: Sequence[str]
    """The engine: it opens window and devices, and dances."""
    show: str
    """What the engine is to play, as it understands it; the supervisor does not."""
    audio: Sequence[str] = ()
    """The process that listens or plays; empty: the engine does that itself."""
    guard: Sequence[str] = ()
    """The process with the black window; empty: none."""
    screen: tuple[bool, str | None] = (False, None)
    """Whether the picture is full screen at the start, and on which monitor."""
    osc: socket.socket | None = None
    """Where OSC is received, bound already: the socket outlives the engine, and what comes meanwhile waits in it."""
    osc_reader: Sequence[str] = ()
    """The process that reads that socket for the engine; empty: the engine does. It gets the numbers of two sockets, to
    the engine and the one that is read, before the usual two."""
    journal: Path | None = None
    spare_after: float = 2.0
    """Seconds that an engine has danced before the next one begins to prepare itself."""
    spare: bool = True
    """Whether another engine waits; without it one is started when it is needed."""
    label: str = ""
    """By what a supervisor that begins anew finds this show's engine; empty: it cannot."""
    lead: socket.socket | None = None
    """Where machines that stand by may follow this show; bound and listening."""
    identity: Identity | None = None
    """This machine's key, where there is a machine to lead or to follow; ..."""
    pairings: Pairings | None = None
    """... and those that it is paired with."""
    follow: tuple[str, int] | None = None
    """The machine whose show is followed; this one takes over from it."""
    budget: int = 0
    """Bytes that an engine may come to need before the spare takes over from it; 0: any number."""


@dataclass(slots=True)
class Report:
    """What happened, for the status line and the terminal."""

    restarts: int = 0
    late: int = 0
    """How often the engine's heart was late, ..."""
    spared: int = 0
    """... and how often so late that it would have been ended on a machine with less to do."""
    slowdown: float = 1.0
    """How many times slower the machine is than a quiet one."""
    overload: float = 0.0
    """How much too much the machine has to do for the show, 0 to 1; 0 while nothing of it is felt."""
    reaped: int = 0
    """Processes that had lost who started them, and were cleared away when they had ended."""
    calm: bool = False
    takeover_s: float | None = None
    """From the last engine's end to the first picture of the one that took over."""
    audio_restarts: int = 0
    osc_restarts: int = 0
    spare: bool = False
    """Whether another engine is ready."""
    guard: bool = False
    lines: int = 0
    """Lines of the show that the supervisor has."""
    disk: dict[str, int] = field(default_factory=dict)
    """The journal on disk: lines, bytes, what was dropped."""
    memory_mb: dict[str, float] = field(default_factory=dict)
    epoch: int = 1
    """Which leader this is; whoever takes over counts one on, and the higher number rules."""
    fenced: bool = False
    """Whether another machine leads: this one is dark."""
    followers: int = 0
    """Machines that stand by."""
    follows: str = ""
    """Whom this machine follows; empty: nobody, it leads."""
    silent_s: float | None = None
    """How long the leader had been silent when this machine took over; None: it has not."""
    compared: int = 0
    """Measures whose state was compared with the leader's, ..."""
    different: int = 0
    """... that were another one, ..."""
    ready: bool = False
    """Whether this machine, which follows, could go on with the show now; ..."""
    is_deputy: bool = False
    """... and is the one that is to."""
    deputy: str = ""
    """Who takes over from this machine, which leads; empty: nobody is ready to."""
    strangers: int = 0
    """Who wanted to take part and is not paired."""
    claims_refused: int = 0
    """Claims to lead that were old, far off or not signed."""
    lines_refused: int = 0
    """Lines of other machines that made no sense."""
    expired: str = ""
    """Machines whose certificates have expired."""
    repaired: int = 0
    """... and how often a snapshot made them one again."""

    adopted: int = 0
    """How often another supervisor took this show's engine over."""

    def facts(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)

    def restore(self, facts: Mapping[str, Any]) -> None:
        """Go on with what another supervisor told, as far as it holds for this one."""
        for name in ("restarts", "calm", "takeover_s", "audio_restarts", "lines", "epoch", "fenced", "follows",
                     "silent_s", "compared", "different", "repaired", "adopted"):  # fmt: skip
            if name in facts and (facts[name] is None or isinstance(facts[name], bool | int | float | str)):
                setattr(self, name, facts[name])
