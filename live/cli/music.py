"""Command `live music map`: the measures of a piece of music, proposed, corrected, imported and exported."""

import json
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Annotate music: measures and phrases.", no_args_is_help=True)


@app.command("map")
def measure_map(
    file: Annotated[Path, typer.Argument(help="A music file: wav, flac, ogg, mp3, m4a …")],
    fix: Annotated[
        Path | None,
        typer.Option("--fix", help="Corrections, as a JSON list (`live docs measures`).", metavar="FIXES.json"),
    ] = None,
    start: Annotated[
        Path | None,
        typer.Option("--from", help="Take this map instead of a proposal.", metavar="LINES.csv|.mid|.txt"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Write the map: Sonic Visualiser, MIDI, Audacity, patch.", metavar="OUT.csv|.mid|.txt|.toml"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the map as JSON.")] = False,
) -> None:
    """Find the measure lines of a whole piece, correct them, and write them for the show or other programs."""
    from live.app.offline.music_map import map_values, read_fixes, read_measures
    from live.library.music_map_file import write_map

    found = read_measures(file, [] if fix is None else read_fixes(fix), start)
    if out is not None:
        write_map(found, out)
    if as_json:
        print(json.dumps({"file": str(file), **map_values(found)}))
        return
    for line in found.lines:
        run = "  ramp" if line.tempo == "ramp" else ""
        name = next((f"  phrase {each.name}" for each in found.phrases if each.measure == line.measure), "")
        print(f"{line.time_s:9.3f} s  measure {line.measure:4}  {line.beats} beats{run}{name}")
    print(f"{len(found.lines)} measure lines, {found.bpm:.1f} bpm on average")


@app.command("curves")
def curves(
    file: Annotated[Path, typer.Argument(help="A music file, or a MIDI file.")],
    feature: Annotated[
        list[str] | None,
        typer.Option(help="A feature: loudness, density, brightness, low, build, pitch, chroma C … Left out: all."),
    ] = None,
    start: Annotated[
        Path | None, typer.Option("--from", help="The piece's measures.", metavar="LINES.csv|.mid|.txt")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the tables of a patch.", metavar="CURVES.toml")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the points as JSON.")] = False,
) -> None:
    """Take curves from music, a value for each beat over its measures, for [[react]] and [[signal]] of a patch."""
    from live.app.offline.music_map import MapProposal, hear
    from live.base.errors import PersonError
    from live.control.audio.music_file import MusicFileError, read_music
    from live.document.music_curves import (
        NOTE_FEATURES,
        SOUND_FEATURES,
        checked_features,
        curve_tables,
        curves_of_midi,
        curves_of_sound,
    )
    from live.library.music_map_file import read_map
    from live.library.whole_file import write_atomically

    is_midi = file.suffix.lower() in (".mid", ".midi")
    names = checked_features(feature or [], NOTE_FEATURES if is_midi else SOUND_FEATURES)
    if is_midi:
        measures = read_map(file if start is None else start)
        found = curves_of_midi(file, measures, names)
    else:
        try:
            music = read_music(file)
        except MusicFileError as error:
            raise PersonError(str(error)) from None
        measures = MapProposal(hear(music)).map() if start is None else read_map(start)
        found = curves_of_sound(music, measures, names)
    text = curve_tables(found, measures.lines[0].measure)
    if out is not None:
        write_atomically(text.encode(), out, "--out")
    if as_json:
        print(json.dumps({name: [list(point) for point in points] for name, points in found.items()}))
    elif out is None:
        print(text, end="")
