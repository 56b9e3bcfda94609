"""Starting tempo: at which a show begins, by what was asked for and what is heard."""

from live.app.practice import FASTEST, SLOWEST, practice_tempo
from live.app.session_sound import Sound
from live.app.wish import Wish
from live.control.midi.midi_song import read_song
from live.show.load import LoadedShow


def start_tempo(wish: Wish, loaded: LoadedShow, sound: Sound) -> float | None:
    """The tempo [bpm] to begin with; None if the patch's music is played and its own tempo and downbeat hold."""
    if wish.practises:
        return practice_tempo(wish, loaded)
    if wish.bpm is not None:
        return wish.bpm
    if wish.midi_file is not None:
        return min(max(read_song(wish.midi_file).tempo, SLOWEST), FASTEST)
    return None if sound.known else loaded.patch.clock.bpm
