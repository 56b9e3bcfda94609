"""MIDI learn during a show: the bindings in force, and the thread that saves them next to the patch."""

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.events.midi import ForgetMidi, LearnMidi
from live.control.midi.midi_binding import BadBinding, Binding, merge_bindings
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_learn import MidiLearn, parse_values
from live.show.patch.midi_bindings import learned_bindings, written_bindings
from live.show.patch.section_io import MidiSection


class MidiMapWriter:
    """Saves learned bindings next to the patch, one change after the other. `save`: call in the show's thread."""

    def __init__(self, patch: Path, report: Callable[[str], None]) -> None:
        """`patch`: its file. `report` is called with the result in words, in any thread."""
        self._patch, self._report = patch, report
        self._lock = threading.Lock()
        self._threads: list[threading.Thread] = []

    def save(self, learned: Sequence[Binding], forgotten: Sequence[str] = ()) -> None:
        """Save the bindings `learned`, and remove those of the controls `forgotten`."""
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(learned, forgotten), name="midi map"))
        self._threads[-1].start()

    def _write(self, learned: Sequence[Binding], forgotten: Sequence[str]) -> None:
        from live.library.whole_file import write_atomically
        from live.show.patch.learned_midi import updated_mapping_text
        from live.show.patch.patch_search_path import learned_path

        path = learned_path(self._patch)
        try:
            with self._lock:
                write_atomically(updated_mapping_text(self._patch, learned, forgotten).encode(), path, "MIDI map")
        except (PersonError, OSError) as error:
            self._report(f"MIDI: NOT SAVED for the next show: {error}")
        except Exception as error:
            FAULTS.record("saving the MIDI map", error)
            self._report(f"MIDI: NOT SAVED for the next show: {type(error).__name__}: {error}")
        else:
            self._report(f"MIDI: saved in {path}")

    def wait(self) -> None:
        """Wait until all changes are written."""
        for thread in self._threads:
            thread.join()


class MidiLearnSession:
    """The MIDI map in force: the patch's, with changes learned since it was read. Thread: the show's."""

    def __init__(self, section: MidiSection, midi_input: MidiInput | None, writer: MidiMapWriter) -> None:
        """`midi_input`: the input to learn from; without it nothing can be learned."""
        self._section, self._input, self._writer = section, midi_input, writer
        self._added: list[Binding] = []
        self._forgotten: set[str] = set()
        self.refused = ""
        """The last refused request, in words."""
        self.last_change = ""
        """The last change, in words."""

    @property
    def pending_control(self) -> str:
        """The control that is being learned; empty if there is none."""
        learning = None if self._input is None else self._input.learning
        return "" if learning is None else learning.control

    @property
    def bindings(self) -> tuple[Binding, ...]:
        """The map in force."""
        places = {one.trigger for one in self._added}
        learned = learned_bindings(self._section)
        kept = [one for one in learned if one.control not in self._forgotten and one.trigger not in places]
        return merge_bindings(written_bindings(self._section), [*kept, *self._added])

    def update_patch(self, section: MidiSection) -> None:
        """Use a patch that was read again, and drop changes that it contains by now."""
        self._section = section
        learned = learned_bindings(section)
        self._added = [one for one in self._added if one not in learned]
        self._forgotten &= {one.control for one in learned}

    def handle(self, event: LearnMidi | ForgetMidi, on_change: Callable[[], None]) -> None:
        """Start or cancel learning, or forget a control; `on_change` is called if that changes the map."""
        self.refused = ""
        if isinstance(event, ForgetMidi):
            self._forget(event.address, on_change)
        elif self._input is None:
            self.refused = "MIDI: cannot learn without an input: name a port, as in `live play --midi NAME`"
        elif not event.address.strip():
            self.last_change = (
                f"MIDI: learning {self.pending_control} cancelled" if self.pending_control else self.last_change
            )
            self._input.learning = None
        else:
            try:
                address = event.address.strip()
                self._input.learning = MidiLearn(address, parse_values(address, event.given))
            except BadBinding as error:
                self.refused = f"MIDI: {error}"

    def add_learned(self, binding: Binding) -> None:
        """Add the binding that was learned."""
        self._added = [one for one in self._added if one.trigger != binding.trigger] + [binding]
        self._forgotten.discard(binding.control)
        self.last_change = f"MIDI: {describe_binding(binding)} now controls {binding.control}"
        self._writer.save([binding])

    def _forget(self, address: str, on_change: Callable[[], None]) -> None:
        known = [one for one in self.bindings if one.control == address and one not in written_bindings(self._section)]
        if not known:
            written = any(one.control == address for one in written_bindings(self._section))
            why = "it is in the patch's own map" if written else "nothing was learned for it"
            self.refused = f"MIDI: {address!r} cannot be forgotten: {why}"
            return
        self._added = [one for one in self._added if one.control != address]
        self._forgotten.add(address)
        self.last_change = f"MIDI: {', '.join(map(describe_binding, known))} no longer controls {address}"
        self._writer.save([], [address])
        on_change()


def describe_binding(binding: Binding) -> str:
    """Return the controller or note of a binding, in words."""
    number = "" if binding.kind in ("bend", "pressure") else f" {binding.number}"
    channel = f" of channel {binding.channel}" if binding.channel else ""
    return f"{'controller' if binding.kind == 'cc' else binding.kind}{number}{channel}"
