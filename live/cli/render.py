"""Command `live render`: renders a show offline and deterministically to a film."""

from pathlib import Path
from typing import Annotated

import typer


def render(
    patch: Annotated[str | None, typer.Argument(help="A patch. Default: the first show.")] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="The film to write (.mp4, .mov, .mkv), a folder for PNG pictures, or the dancers' motion "
            "(.glb, .usdc, .bvh, .csv, .json). Default: a film of the show's name, here.",
            metavar="FILE|FOLDER",
        ),
    ] = None,
    audio: Annotated[str | None, typer.Option(help="A music file. Default: the patch's music.", metavar="FILE")] = None,
    midi_file: Annotated[
        Path | None,
        typer.Option(help="A MIDI file to take beats from, as in `live play`.", metavar="FILE.mid"),
    ] = None,
    bpm: Annotated[float | None, typer.Option(help="No music: the internal clock at this tempo.")] = None,
    size: Annotated[str, typer.Option(help="Width and height in pixels.", metavar="WxH")] = "1280x720",
    fps: Annotated[str, typer.Option(help="Frames per second: 25, 59.94, 24000/1001.", metavar="N")] = "60",
    seconds: Annotated[float | None, typer.Option(help="Length. Default: the music's, or 60 s without music.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**31 - 1, help="Random seed of the show.")] = None,
    steps: Annotated[
        Path | None, typer.Option(help="Use the recordings of this folder instead.", file_okay=False)
    ] = None,
    fine: Annotated[bool, typer.Option("--fine", help="Draw at GPU quality even without a GPU; slow.")] = False,
    alpha: Annotated[
        bool,
        typer.Option("--alpha", help="The dancers on a transparent background (.mov, .mkv, PNG); implies --fine."),
    ] = False,
    guides: Annotated[
        bool,
        typer.Option("--guides", help="Draw each dancer's agent, its target, and locked feet."),
    ] = False,
    click: Annotated[bool | None, typer.Option(help="A click on every beat. Default: as the patch says.")] = None,
    taps: Annotated[bool | None, typer.Option(help="Tap shoes on all feet. Default: as the patch says.")] = None,
    journal: Annotated[Path | None, typer.Option(help="Write the journal here as well.")] = None,
    report: Annotated[Path | None, typer.Option(help="Write motion figures as JSON.")] = None,
) -> None:
    """Render a show to a film with sound, or its motion to a file for other programs; bit-identical each time."""
    from rich.console import Console

    from live.app.film.film_names import parse_film_path, parse_rate
    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.option_values import check_range, check_writable, parse_size
    from live.base.errors import PersonError
    from live.show.patch.patch_search_path import show_stem

    check_range(bpm, "--bpm", 20, 400)
    check_range(seconds, "--seconds", 0.02, 7 * 86400)
    rate = parse_rate(fps)
    for path, name in ((journal, "--journal"), (report, "--report")):
        check_writable(path, name)
    out = out or Path(f"{show_stem(patch)}{'.mov' if alpha else '.mp4'}")
    film = parse_film_path(out, "--out", alpha=alpha, inputs=[audio, patch])
    console = Console(stderr=True, highlight=False)
    warm_kernels(console)  # before modules with kernels are imported
    from live.app.film.show_film import film_show
    from live.app.launch_options import LaunchOptions
    from live.app.session_audio import choose_audio

    options = LaunchOptions(
        patch=patch, audio=audio, bpm=bpm, steps=steps, seed=seed, journal=journal, size=parse_size(size), fps=rate,
        midi_file=midi_file,
    )  # fmt: skip
    loaded = options.load()
    for note in loaded.notes:
        console.print(f"note: {note}", style="yellow", soft_wrap=True, markup=False)
    sound = choose_audio(options, loaded)
    if sound.device is not None:
        raise PersonError(f"--audio {audio!r} is an input device: `live render` needs a music file")
    length = seconds or (60.0 if sound.music is None else sound.music.duration)
    made = film_show(
        options, loaded, sound, path=film, seconds=length, console=console, report=report, fine=fine, guides=guides,
        click=click, taps=taps, alpha=alpha,
    )  # fmt: skip
    console.print(made, soft_wrap=True, markup=False)
