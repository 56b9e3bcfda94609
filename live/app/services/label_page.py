"""The studio's page on which a person labels the patterns of recorded couples while watching them (H021).

A page asks for the motion of a take and sends all labels whenever one changes. They are checked, and written beside the
pairs. A page that has not seen the latest labels is refused, so that two pages do not overwrite each other.

A page may ask for suggestions: the take's leader is understood as a row of units of the takes that have labels, whose
labels come with them (H026: a set of examples grows from a few). They are shown, and become labels only when a person
takes them.
"""

import asyncio
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.app.services.listening_socket import page_socket
from live.base.errors import PersonError
from live.control.web.http_protection import BACKLOG
from live.control.web.studio_server import Frames, StudioServer
from live.library.partner_pairs import PartnerExamples, read_pairs
from live.library.pattern_labels import (
    NO_LABELS,
    PatternLabels,
    checked_labels,
    labels_path,
    read_labels,
    write_labels,
)
from live.motion.clip import Clip, resample
from live.motion.partner.couple_comparison import danced_labels
from live.motion.partner.couple_states import PATTERN_BEATS
from live.motion.partner.evaluation import joint_positions
from live.motion.partner.partner_synthesis import SearchSettings, StageTimer, decode_input, no_clock
from live.motion.partner.units import cut_units

LABEL_PATH: Final = "/studio/label"
MAX_BYTES: Final = 2_000_000
"""Maximum bytes of a message: all labels of many takes."""
RATE: Final = 30.0
"""Samples of a take per second [Hz]."""
MILLIMETRES: Final = 1000.0
MAX_METRES: Final = 32.0
"""Places farther from the middle of a take do not fit into its samples [m]."""
DEFAULT_LABELS: Final = ("basic", "inside turn", "outside turn", "cross-body lead")
"""Labels of a page on which none was given; a person renames and adds others."""


@dataclass(slots=True, eq=False)
class LabelDesk:
    """The labels of a file of pairs, and who has seen which. Thread: any, one at a time."""

    known: PartnerExamples
    path: Path
    labels: PatternLabels
    revision: int = 0
    """Counts what was written."""

    def facts(self) -> dict[str, Any]:
        """Return what a page shows, as values for JSON."""
        takes = [
            {
                "name": example.name,
                "seconds": (example.follower.sample_count - 1) / example.follower.sample_rate,
                "beats": np.round(example.beats / example.follower.sample_rate, 4).tolist(),
                "style": pair.style,
            }
            for example, pair in zip(self.known.units.examples, self.known.pairs_file.pair, strict=True)
        ]
        return {
            "label": {
                "pairs": self.known.file.name, "file": str(self.path), "pattern_beats": PATTERN_BEATS, "rate": RATE,
                "takes": takes, "revision": self.revision, **_values(self.labels),
            }
        }  # fmt: skip

    def answer(self, text: str) -> Frames:
        """Return the frames of the answer to a page's message."""
        try:
            asked = json.loads(text)
            match asked:
                case {"take": str(name)}:
                    return self._motion(name)
                case {"suggest": str(name)}:
                    return [json.dumps(self._suggest(name))]
                case {"save": dict(values), "revision": int(revision)}:
                    return [json.dumps(self._save(values, revision))]
            raise PersonError("a take, or labels to save expected")
        except (ValueError, RecursionError):
            return [_refused("an object expected", "")]
        except PersonError as error:
            return [_refused(error.message, error.remedy or "")]

    def _motion(self, name: str) -> Frames:
        """Return the facts of a take's motion, and its joints as int16 [mm]: samples x 2 dancers x 22 joints x 3."""
        names = [one.name for one in self.known.units.examples]
        if name not in names:
            raise PersonError(f"there is no take {name[:64]!r}")
        index = names.index(name)
        leader = self.known.leaders[index]
        clips: list[Clip] = [self.known.followers[index].clip] if leader is None else [leader.clip]
        clips += [] if leader is None else [self.known.followers[index].clip]
        joints = [joint_positions(resample(clip, RATE)) for clip in clips]
        count = min(map(len, joints))
        both = np.stack([one[:count] for one in joints], axis=1)
        ways = both[:, :, 0]
        middle = 0.5 * (ways.min(axis=(0, 1)) + ways.max(axis=(0, 1))) * (1.0, 0.0, 1.0)
        reach = np.ptp(ways, axis=(0, 1))
        packed = np.clip(both - middle, -MAX_METRES, MAX_METRES) * MILLIMETRES
        told = {
            "kind": "motion", "take": name, "samples": count, "dancers": len(clips),
            "width": float(reach[0]), "depth": float(reach[2]),
        }  # fmt: skip
        return [json.dumps(told), np.ascontiguousarray(np.round(packed), "<i2").tobytes()]

    def _suggest(self, name: str) -> dict[str, Any]:
        """Return what the labels of other takes say of a take."""
        examples = self.known.units.examples
        example = next((one for one in examples if one.name == name), None)
        if example is None:
            raise PersonError(f"there is no take {name[:64]!r}")
        units = cut_units([one for one in examples if one.name != name and self.labels.of(one.name)] or [example])
        if units.examples[0] is example:
            raise PersonError("nothing can be suggested yet", "label patterns of another take first")
        search = SearchSettings(beats=example.beats / example.follower.sample_rate)
        _, reading = decode_input(example.control, units, search, StageTimer(no_clock))
        spans = danced_labels(reading, units, self.labels.at)
        told = [{"from": one.begin, "to": one.end, "label": one.label} for one in spans if one.label is not None]
        return {"kind": "suggested", "take": name, "spans": told}

    def _save(self, values: dict[str, Any], revision: int) -> dict[str, Any]:
        if revision != self.revision:
            return {
                "kind": "changed", "revision": self.revision, **_values(self.labels),
                "refused": [{"what": "another page has changed the labels", "remedy": "its labels are shown now"}],
            }  # fmt: skip
        seconds = {
            one.name: (one.follower.sample_count - 1) / one.follower.sample_rate for one in self.known.units.examples
        }
        labels = checked_labels(values, seconds)
        write_labels(self.path, labels)
        self.labels, self.revision = labels, self.revision + 1
        return {"kind": "saved", "revision": self.revision, **_values(labels)}


def _values(labels: PatternLabels) -> dict[str, Any]:
    return {"labels": list(labels.labels), "pattern": [one.model_dump() for one in labels.patterns]}


def _refused(what: str, remedy: str) -> str:
    return json.dumps({"kind": "refused", "refused": [{"what": what, "remedy": remedy}]})


def open_desk(pairs: Path, labels: Path | None) -> LabelDesk:
    """Read pairs and labels; PersonError for anything invalid."""
    known = read_pairs(pairs)
    names = [one.name for one in known.units.examples]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise PersonError(f"{pairs}: two pairs are called {twice!r}", 'a name for each pair: name = "..."')
    unsure = next((one.name for one in known.units.examples if len(one.beats) < PATTERN_BEATS), None)
    if unsure is not None:
        raise PersonError(f"{pairs}: {unsure} has no beats, which cut its patterns", "give bpm and first_beat_s")
    path = labels_path(pairs) if labels is None else labels
    there = read_labels(path) if path.exists() else NO_LABELS
    if not there.labels:
        there = PatternLabels(DEFAULT_LABELS, there.patterns)
    checked_labels(_values(there), {one.name: one.follower.seconds for one in known.units.examples})
    return LabelDesk(known, path, there)


def serve_labels(desk: LabelDesk, where: tuple[str, int], key: str) -> None:
    """Serve the page at an address until the program is interrupted. PersonError if nobody can listen there."""

    busy = asyncio.Lock()

    async def take(text: str) -> Frames:
        async with busy:  # a search takes a second
            return await asyncio.to_thread(desk.answer, text)

    async def run() -> None:
        with page_socket(where, BACKLOG) as listening:
            server = StudioServer(listening, key, desk.facts, LABEL_PATH, take, max_bytes=MAX_BYTES)
            await server.run_until(asyncio.get_running_loop().create_future())

    asyncio.run(run())
