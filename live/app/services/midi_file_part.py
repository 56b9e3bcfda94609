"""The part of a show that is a MIDI file: its tempo map leads the beat, its notes work what the patch's map says."""

from pathlib import Path
from typing import Any

from live.clock.ticks import TICK
from live.control.events.events import ControlEvent
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_song import read_song
from live.control.midi.midi_song_player import MidiSongPlayer
from live.show.core import Show
from live.show.engine import Engine
from live.show.patch.patch import Patch


class MidiFilePart:
    """Between a show and a song. Thread: the one that runs the show; live and offline alike."""

    def __init__(self, path: Path, show: Show, engine: Engine, *, begun: int = 0) -> None:
        """`begun`: the tick after which the show is gone on with. PersonError for a file that cannot be played."""
        self._show = show
        song = read_song(path)
        self._player = MidiSongPlayer(song, _bindings(show.patch), beats_per_measure=show.timeline.beats_per_measure)
        if begun:
            self._due((begun + 1) * TICK)  # another engine has told that
        engine.timed.append(self._due)
        engine.patched.append(self.take_patch)

    def take_patch(self, patch: Patch) -> None:
        """Its notes do what another patch says from now on."""
        self._player.take(_bindings(patch))

    def start(self) -> None:
        """Nothing is to be opened."""

    def stop(self) -> None:
        """Nothing is to be closed."""

    def frame(self) -> None:
        """After each frame; it goes by ticks."""

    def status(self) -> dict[str, Any]:
        """For the status line."""
        return self._player.facts()

    def _due(self, until: float) -> list[ControlEvent]:
        timeline = self._show.timeline
        return self._player.due(until, tempo=timeline.tempo, beats_per_measure=timeline.beats_per_measure)


def play_file(path: Path | None, show: Show, engine: Engine) -> None:
    """Let a file, if there is one, lead a show that nobody watches."""
    if path is not None:
        MidiFilePart(path, show, engine)


def _bindings(patch: Patch) -> tuple[Binding, ...]:
    """What a person wrote and taught; the pedals and keys that work without a map are for hands and feet."""
    return patch.midi.bindings if patch.midi.map or patch.midi.learned else ()
