"""MIDI learn during a show: the bindings in force, and the thread that saves them next to the patch."""

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
    """Saves learned bindings next to the patch, one change after the other. `keep`: call in the show's thread."""

    def __init__(self, patch: Path, told: Callable[[str], None]) -> None:
        """`patch`: its file. `told` is called with the result in words, in any thread."""
        self._patch, self._told = patch, told
        self._turn = threading.Lock()
        self._threads: list[threading.Thread] = []

    def keep(self, learned: Sequence[Binding], forgotten: Sequence[str] = ()) -> None:
        """Save the bindings `learned`, and remove those of the controls `forgotten`."""
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
            self._told(f"MIDI: NOT SAVED for the next show: {error}")
        except Exception as error:
            FAULTS.note("saving the MIDI map", error)
            self._told(f"MIDI: NOT SAVED for the next show: {type(error).__name__}: {error}")
        else:
            self._told(f"MIDI: saved in {path}")

    def wait(self) -> None:
        """Wait until all changes are written."""
        for thread in self._threads:
            thread.join()


class MidiLearning:
    """The MIDI map in force: the patch's, with changes learned since it was read. Thread: the show's."""

    def __init__(self, section: MidiSection, listens: MidiInput | None, keeping: MidiKeeping) -> None:
        """`listens`: the input to learn from; without it nothing can be learned."""
        self._section, self._listens, self._keeping = section, listens, keeping
        self._added: list[Binding] = []
        self._forgotten: set[str] = set()
        self.refused = ""
        """The last refused request, in words."""
        self.said = ""
        """The last change, in words."""

    @property
    def waits_for(self) -> str:
        """The control that is being learned; empty if there is none."""
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
        """Use a patch that was read again, and drop changes that it contains by now."""
        self._section = section
        learned = [one.binding for one in section.learned]
        self._added = [one for one in self._added if one not in learned]
        self._forgotten &= {one.control for one in learned}

    def ask(self, event: LearnMidi | ForgetMidi, took: Callable[[], None]) -> None:
        """Start or cancel learning, or forget a control; `took` is called if that changes the map."""
        self.refused = ""
        if isinstance(event, ForgetMidi):
            self._forget(event.address, took)
        elif self._listens is None:
            self.refused = "MIDI: cannot learn without an input: name a port, as in `live play --midi NAME`"
        elif not event.address.strip():
            self.said = f"MIDI: learning {self.waits_for} cancelled" if self.waits_for else self.said
            self._listens.learning = None
        else:
            try:
                address = event.address.strip()
                self._listens.learning = MidiLearn(address, values_of(address, event.given))
            except BadBinding as error:
                self.refused = f"MIDI: {error}"

    def learned(self, binding: Binding) -> None:
        """Add the binding that was learned."""
        self._added = [one for one in self._added if one.place != binding.place] + [binding]
        self._forgotten.discard(binding.control)
        self.said = f"MIDI: {words_of(binding)} now controls {binding.control}"
        self._keeping.keep([binding])

    def _forget(self, address: str, took: Callable[[], None]) -> None:
        known = [one for one in self.bindings if one.control == address and one not in self._section.written]
        if not known:
            written = any(one.control == address for one in self._section.written)
            why = "it is in the patch's own map" if written else "nothing was learned for it"
            self.refused = f"MIDI: {address!r} cannot be forgotten: {why}"
            return
        self._added = [one for one in self._added if one.control != address]
        self._forgotten.add(address)
        self.said = f"MIDI: {', '.join(map(words_of, known))} no longer controls {address}"
        self._keeping.keep([], [address])
        took()


def words_of(binding: Binding) -> str:
    """Return the controller or note of a binding, in words."""
    number = "" if binding.kind in ("bend", "pressure") else f" {binding.number}"
    channel = f" of channel {binding.channel}" if binding.channel else ""
    return f"{'controller' if binding.kind == 'cc' else binding.kind}{number}{channel}"
