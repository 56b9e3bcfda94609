"""MidiLearning: what is learned and forgotten while a show runs, until the patch that is read anew has it itself.

Keeping what MIDI controllers were taught: beside the patch, whole or not at all, in a thread: no frame waits.
"""

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.events.midi import ForgetMidi, LearnMidi
from live.control.midi.midi_binding import BadBinding, Binding, joined
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_learn import MidiLearn, values_of
from live.show.patch.section_io import MidiSection


class MidiKeeping:
    """Writes one change after the other. `keep` belongs to the show's thread."""

    def __init__(self, patch: Path, told: Callable[[str], None]) -> None:
        """`patch`: its file. `told` hears in words what became of it, from any thread."""
        self._patch, self._told = patch, told
        self._turn = threading.Lock()
        self._threads: list[threading.Thread] = []

    def keep(self, learned: Sequence[Binding], forgotten: Sequence[str] = ()) -> None:
        """Let the patch have these, and nothing for the controls `forgotten`."""
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(learned, forgotten), name="midi map"))
        self._threads[-1].start()

    def _write(self, learned: Sequence[Binding], forgotten: Sequence[str]) -> None:
        from live.app.whole_file import write_whole
        from live.show.patch.learned_midi import changed_learned
        from live.show.patch.patch_search_path import learned_path

        path = learned_path(self._patch)
        try:
            with self._turn:
                write_whole(changed_learned(self._patch, learned, forgotten).encode(), path, "MIDI map")
        except (PersonError, OSError) as error:
            self._told(f"MIDI: NOT KEPT for the next show: {error}")
        except Exception as error:
            FAULTS.note("the keeping of what MIDI was taught", error)
            self._told(f"MIDI: NOT KEPT for the next show: {type(error).__name__}: {error}")
        else:
            self._told(f"MIDI: kept in {path}")

    def wait(self) -> None:
        """Wait until all is written."""
        for thread in self._threads:
            thread.join()


class MidiLearning:
    """The map in force: the patch's, with what was taught since it was read. Thread: the show's."""

    def __init__(self, section: MidiSection, listens: MidiInput | None, keeping: MidiKeeping) -> None:
        """`listens`: where somebody may move something; without it nothing can be learned."""
        self._section, self._listens, self._keeping = section, listens, keeping
        self._added: list[Binding] = []
        self._forgotten: set[str] = set()
        self.refused = ""
        """What was asked for last and cannot be."""
        self.said = ""
        """What happened last."""

    @property
    def waits_for(self) -> str:
        """The control for which something is to be moved; empty if there is none."""
        learning = None if self._listens is None else self._listens.learning
        return "" if learning is None else learning.control

    @property
    def bindings(self) -> tuple[Binding, ...]:
        """The map in force."""
        places = {one.place for one in self._added}
        learned = [one.binding for one in self._section.learned]
        kept = [one for one in learned if one.control not in self._forgotten and one.place not in places]
        return joined(self._section.written, [*kept, *self._added])

    def take(self, section: MidiSection) -> None:
        """The patch was read anew: what it has by now is no more ours to remember."""
        self._section = section
        learned = [one.binding for one in section.learned]
        self._added = [one for one in self._added if one not in learned]
        self._forgotten &= {one.control for one in learned}

    def ask(self, event: LearnMidi | ForgetMidi, took: Callable[[], None]) -> None:
        """Begin or end to learn, or forget; `took` is told when the map is another one."""
        self.refused = ""
        if isinstance(event, ForgetMidi):
            self._forget(event.address, took)
        elif self._listens is None:
            self.refused = "MIDI: nothing can be learned: name a port, as in `live play --midi NAME`"
        elif not event.address.strip():
            self.said = f"MIDI: nothing is learned for {self.waits_for}" if self.waits_for else self.said
            self._listens.learning = None
        else:
            try:
                address = event.address.strip()
                self._listens.learning = MidiLearn(address, values_of(address, event.given))
            except BadBinding as error:
                self.refused = f"MIDI: {error}"

    def learned(self, binding: Binding) -> None:
        """This was moved for what is learned."""
        self._added = [one for one in self._added if one.place != binding.place] + [binding]
        self._forgotten.discard(binding.control)
        self.said = f"MIDI: {words_of(binding)} works {binding.control}"
        self._keeping.keep([binding])

    def _forget(self, address: str, took: Callable[[], None]) -> None:
        known = [one for one in self.bindings if one.control == address and one not in self._section.written]
        if not known:
            written = any(one.control == address for one in self._section.written)
            why = "it stands in the patch's own map" if written else "nothing was learned for it"
            self.refused = f"MIDI: {address!r} cannot be forgotten: {why}"
            return
        self._added = [one for one in self._added if one.control != address]
        self._forgotten.add(address)
        self.said = f"MIDI: {', '.join(map(words_of, known))} works {address} no more"
        self._keeping.keep([], [address])
        took()


def words_of(binding: Binding) -> str:
    """What is played, in words."""
    number = "" if binding.kind in ("bend", "pressure") else f" {binding.number}"
    channel = f" of channel {binding.channel}" if binding.channel else ""
    return f"{'controller' if binding.kind == 'cc' else binding.kind}{number}{channel}"
