"""Configuration of the supervisor and its report."""

import socket
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

from live.supervisor.network.identity import Identity, Pairings
from live.supervisor.recovery_log import RecoveryLog


class ShowListener(Protocol):
    """Gets all lines of the show: the leader's side of the bus. Thread: the supervisor's."""

    on_restart: Callable[[str, str, str], None]
    """Called with kind, name and process of a part of the show, other than a node, that is to be started again."""

    def add_line(self, line: str) -> None:
        """Take one line; never waits."""
        ...

    def update(self, log: RecoveryLog, report: "Report") -> None:
        """Do what is due. `log`: the show so far; figures go into `report`. Called once a round."""
        ...

    def close(self) -> None:
        """Release everything."""
        ...


@dataclass(frozen=True, slots=True)
class SupervisorConfig:
    """Processes and sockets of a show. A command gets two more descriptors as its last arguments."""

    engine: Sequence[str]
    """The engine: opens window and devices, and runs the show."""
    show: str
    """The show, in the engine's format; opaque to the supervisor."""
    audio: Sequence[str] = ()
    """The audio process; empty: the engine handles audio itself."""
    fallback_window: Sequence[str] = ()
    """The process with the fallback window; empty: none."""
    screen: tuple[bool, str | None] = (False, None)
    """Whether the picture starts in full screen, and on which monitor."""
    osc: socket.socket | None = None
    """Bound socket that receives OSC. It outlives the engine, so packets wait in it during a failover."""
    osc_reader: Sequence[str] = ()
    """The process that reads that socket; empty: the engine does. It gets two more sockets as arguments, to the engine
    and the one to read, before the usual two."""
    journal: Path | None = None
    spare_after: float = 2.0
    """Seconds an engine has run before a spare one is started."""
    spare: bool = True
    """Whether a spare engine is kept ready; otherwise one is started when needed."""
    label: str = ""
    """Label by which a restarted supervisor finds this show's engine; empty: it cannot."""
    lead: socket.socket | None = None
    """Listening socket for standby machines."""
    identity: Identity | None = None
    """This machine's key, if it leads or follows others; ..."""
    pairings: Pairings | None = None
    """... and the machines it is paired with."""
    follow: tuple[str, int] | None = None
    """The machine whose show is followed; this one takes over from it."""
    nodes: ShowListener | None = None
    """The leader's side of the bus, if the show has one."""
    page: Sequence[str] = ()
    """The process that relays the operator's page over the bus; empty: none."""
    page_plan: Callable[[str, bool], str] = lambda show, follows: ""
    """Returns its plan for a show, in the engine's format; `follows`: another machine leads."""
    keys: Mapping[str, str] = field(default_factory=dict, repr=False)
    """What machines that stand by have to know to serve the same pages and phones once they lead."""
    with_keys: Callable[[str, Mapping[str, str]], str] = lambda show, keys: show
    """Returns the show, in the engine's format, with the keys of another machine; ValueError if they are none."""
    memory_budget: int = 0
    """Memory limit of an engine [bytes], above which the spare takes over; 0: none."""


@dataclass(slots=True)
class Report:
    """Figures for the status line and the terminal."""

    restarts: int = 0
    late: int = 0
    """How often the engine's heartbeat was late, ..."""
    spared: int = 0
    """... and how often so late that it would have been killed on a machine with less load."""
    slowdown: float = 1.0
    """Slow-down of the machine against a quiet one."""
    overload: float = 0.0
    """Overload of the machine, 0 to 1; 0 while it is not noticeable."""
    reaped: int = 0
    """Orphaned processes that were reaped after their end."""
    calm: bool = False
    takeover_s: float | None = None
    """Seconds from the last engine's end to the first picture of its successor."""
    audio_restarts: int = 0
    osc_restarts: int = 0
    spare: bool = False
    """Whether a spare engine is ready."""
    guard: bool = False
    lines: int = 0
    """Lines of the show that the supervisor has received."""
    disk: dict[str, int] = field(default_factory=dict)
    """The journal on disk: lines, bytes, dropped lines."""
    memory_mb: dict[str, float] = field(default_factory=dict)
    epoch: int = 1
    """Epoch of this leader; each take-over increments it, and the higher number rules."""
    fenced: bool = False
    """Whether another machine leads and this one is dark."""
    followers: int = 0
    """Number of standby machines."""
    follows: str = ""
    """The machine that is followed; empty: this machine leads."""
    silent_s: float | None = None
    """Silence of the leader before this machine took over [s]; None: it has not."""
    compared: int = 0
    """Measures whose state was compared with the leader's, ..."""
    different: int = 0
    """... those that differed, ..."""
    ready: bool = False
    """Whether this machine, as a follower, could resume the show now; ..."""
    is_deputy: bool = False
    """... and is the deputy."""
    deputy: str = ""
    """The machine that takes over from this leader; empty: none is ready."""
    strangers: int = 0
    """Connections from machines that are not paired."""
    claims_refused: int = 0
    """Claims to lead that were old, too far ahead or not signed."""
    lines_refused: int = 0
    """Invalid lines of other machines."""
    expired: str = ""
    """Machines whose certificates have expired."""
    repaired: int = 0
    """... and how often a snapshot removed the difference."""

    origin: float | None = None
    """Origin of the show's clock on this machine [s of perf_counter]; None before an engine plays here."""
    nodes: dict[str, Any] = field(default_factory=dict)
    """State of each render node, by name."""
    standbys: list[dict[str, Any]] = field(default_factory=list)
    """Each machine that stands by: name, process, state, why, how far it is behind, and since when it is silent."""
    gateways: list[dict[str, Any]] = field(default_factory=list)
    """The engine's report on gateways for phones and their reducer, as in its status."""

    adopted: int = 0
    """How often another supervisor adopted this show's engine."""

    def facts(self) -> dict[str, Any]:
        """Return it as plain values, without what the engine itself has reported."""
        found = asdict(self)
        del found["gateways"]
        return found

    def restore(self, facts: Mapping[str, Any]) -> None:
        """Restore from another supervisor's report the values that hold for this one."""
        for name in ("restarts", "calm", "takeover_s", "audio_restarts", "lines", "epoch", "fenced", "follows",
                     "silent_s", "compared", "different", "repaired", "adopted", "origin"):  # fmt: skip
            if name in facts and (facts[name] is None or isinstance(facts[name], bool | int | float | str)):
                setattr(self, name, facts[name])
