"""Command `live beats`: causal beat tracking of a file or stream, as in a show."""

import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from live.app.offline.beats_report import BeatListener, ManualInputs, TimelineFile
    from live.clock.bar_pointer.state_space import BarPointerModel

Form = Literal["table", "json", "csv"]
STREAM_RATE = 44_100
BLOCK = 512


def beats(
    file: Annotated[Path | None, typer.Argument(help="A music file: wav, flac, ogg, mp3, m4a …")] = None,
    stdin: Annotated[
        bool, typer.Option("--stdin", help="Read raw float32 samples, mono, 44.1 kHz, from standard input.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the beats as JSON.")] = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print the beats as CSV.")] = False,
    click: Annotated[
        Path | None, typer.Option(help="Write the sound with a click on each beat.", metavar="OUT.wav", dir_okay=False)
    ] = None,
    timeline: Annotated[
        Path | None,
        typer.Option(help="Write the dancers' timeline, 64 lines per second.", metavar="OUT.csv", dir_okay=False),
    ] = None,
    explain: Annotated[
        Path | None,
        typer.Option(
            help="Draw what the tracker thought: tempo, half beat, measure line, metre.",
            metavar="OUT.png",
            dir_okay=False,
        ),
    ] = None,
    tracker: Annotated[
        Literal["network", "aubio"], typer.Option(help="Beat tracker: the built-in network, or aubio's tempo.")
    ] = "network",
    metres: Annotated[
        str | None,
        typer.Option(help='Metres that the music may have, such as 3,4 or 5 or "3+2".', metavar="LIST"),
    ] = None,
    likely_bpm: Annotated[
        float | None,
        typer.Option(
            help="Tempo that the beat is likely to have; it decides between half and double. Default: that in the "
            "file's name, if any.",
            metavar="BPM",
        ),
    ] = None,
    tap_bpm: Annotated[float | None, typer.Option(help="Simulate one tap of this tempo …", metavar="BPM")] = None,
    at: Annotated[float | None, typer.Option(help="… at this time [s].", metavar="SECONDS")] = None,
    one_at: Annotated[
        float | None, typer.Option(help='Simulate "this is the one" at this time [s].', metavar="SECONDS")
    ] = None,
) -> None:
    """Track the beats of a music file, or of raw samples on standard input.

    With --stdin, each beat prints a line `B time emitted beat`, usually shortly before the beat; `R time emitted`
    retracts one. With a file, the output is a table, JSON, CSV, or a sound with clicks.
    """
    from live.app.offline.beats_report import BeatListener, ManualInputs
    from live.app.option_values import check_range
    from live.base.errors import PersonError

    check_range(tap_bpm, "--tap-bpm", 40, 240)
    check_range(likely_bpm, "--likely-bpm", 40, 240)
    check_range(at, "--at", 0, 36_000)
    check_range(one_at, "--one-at", 0, 36_000)
    if stdin == (file is not None):
        raise PersonError("live beats needs either a FILE or --stdin", "live beats music.ogg")
    if stdin and (as_json or as_csv or click is not None or explain is not None):
        raise PersonError("--json, --csv, --click and --explain are for files", "give a FILE instead of --stdin")
    if explain is not None and tracker != "network":
        raise PersonError("--explain draws the network's tracker", "leave out --tracker aubio")
    if (tap_bpm is None) != (at is None):
        raise PersonError("--tap-bpm and --at belong together", "--tap-bpm 96 --at 5")
    seeds = ManualInputs(tap_bpm=tap_bpm, tap_at=at, one_at=one_at)
    with contextlib.ExitStack() as stack:
        lines = None if timeline is None else stack.enter_context(_timeline_file(timeline))
        if stdin:
            _track_stream(BeatListener(STREAM_RATE, tracker, seeds, lines, _model(metres, likely_bpm)))
            return
        assert file is not None
        form: Form = "json" if as_json else "csv" if as_csv else "table"
        _track_file(
            file, tracker, seeds, metres=metres, likely_bpm=likely_bpm, form=form, click=click, timeline=lines,
            explain=explain,
        )  # fmt: skip


def _model(metres: str | None, likely_bpm: float | None) -> "BarPointerModel":
    from live.base.errors import PersonError
    from live.clock.bar_pointer.state_space import BarPointerModel

    try:
        return BarPointerModel.expecting(metres.split(",") if metres is not None else (), likely_bpm)
    except ValueError as error:
        raise PersonError(f"--metres {error}", '--metres 3,4 or --metres "3+2"') from None


def _timeline_file(path: Path) -> "TimelineFile":
    from live.app.offline.beats_report import TimelineFile

    return TimelineFile(path)


def _track_stream(listener: "BeatListener") -> None:
    """Track blocks from standard input until it ends, and flush each line; raise PersonError if writing fails."""
    import numpy as np

    from live.app.offline.beats_report import lines_of
    from live.base.errors import PersonError

    source, out = sys.stdin.buffer, sys.stdout
    while data := source.read(BLOCK * 4):
        samples = np.frombuffer(bytearray(data[: len(data) - len(data) % 4]), "<f4")  # kernels need writable arrays
        text = "".join(lines_of(beat) for beat in listener.feed(samples))
        try:
            if text:
                out.write(text)
                out.flush()
        except BrokenPipeError:  # the reader closed the pipe
            raise
        except OSError as error:
            raise PersonError(f"the beats cannot be written ({error.strerror or error})") from None


def _track_file(
    file: Path,
    tracker: Literal["network", "aubio"],
    seeds: "ManualInputs",
    *,
    metres: str | None,
    likely_bpm: float | None,
    form: Form,
    click: Path | None,
    timeline: "TimelineFile | None",
    explain: Path | None,
) -> None:
    from live.app.offline.beats_report import BeatListener, as_csv, as_json, print_table, track_file, write_click
    from live.app.pictures.beats_picture import HypothesesRecord, write_picture
    from live.base.errors import PersonError
    from live.clock.tracking.beat_tracker import BeatTracker
    from live.control.audio.music_file import MusicFileError, read_music, tempo_in_name

    try:
        music = read_music(file)
    except MusicFileError as error:
        raise PersonError(str(error)) from None
    likely = tempo_in_name(file.stem) if likely_bpm is None else likely_bpm
    ear = BeatListener(music.sample_rate, tracker, seeds, timeline, _model(metres, likely))
    if explain is not None and isinstance(ear.tracker, BeatTracker):
        ear.record = HypothesesRecord(ear.tracker)
    beats = track_file(ear, music)
    if form == "json":
        print(as_json(file, tracker, music, beats))
    elif form == "csv":
        print(as_csv(beats))
    else:
        print_table(file, music, beats, ear.note)
    if ear.record is not None and explain is not None:
        write_picture(explain, ear.record, beats)
    if click is not None:
        write_click(click, music, beats)
