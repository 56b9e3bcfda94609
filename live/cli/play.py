"""`live play`: the show, live; on a machine without a screen its film."""

from pathlib import Path
from typing import Annotated

import typer

from live.cli import play_alive, play_music, play_picture, play_ports, play_recording


def play(
    patch: Annotated[
        str | None, typer.Argument(help="A patch (TOML file or folder with show.toml). Default: the first show.")
    ] = None,
    audio: play_music.Audio = None,
    audio_channel: play_music.AudioChannel = None,
    venue: play_music.Venue = None,
    bpm: play_music.Bpm = None,
    link: play_music.Link = None,
    midi: play_music.Midi = None,
    midi_file: play_music.MidiFile = None,
    midi_out: play_music.MidiOut = None,
    midi_clock_out: play_music.MidiClockOut = None,
    click: play_music.Click = None,
    click_channels: play_music.ClickChannels = None,
    seconds: play_music.Seconds = None,
    measures: play_music.Measures = None,
    tempo_share: play_music.TempoShare = None,
    steps: Annotated[
        Path | None,
        typer.Option(
            help="Dance the recordings of this folder (BVH files and TOML) instead of the patch's steps.",
            file_okay=False,
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**31 - 1, help="Seed of all chance in the show.")] = None,
    osc: play_ports.Osc = "127.0.0.1:9010",
    osc_process: play_ports.OscProcess = None,
    osc_musicians: play_ports.OscMusicians = None,
    osc_out: play_ports.OscOut = None,
    dmx: play_ports.Dmx = None,
    web: play_ports.Web = None,
    web_key: play_ports.WebKey = None,
    new_web_key: play_ports.NewWebKey = False,
    web_host: play_ports.WebHost = None,
    psn: play_ports.Psn = None,
    vmc_out: play_ports.VmcOut = None,
    vmc: play_ports.Vmc = None,
    oscquery: play_ports.Oscquery = None,
    audience: play_ports.Audience = None,
    audience_link: play_ports.AudienceLink = None,
    audience_tls: play_ports.AudienceTls = None,
    monitor: play_picture.Monitor = None,
    fullscreen: play_picture.Fullscreen = False,
    operator: play_picture.Operator = None,
    headless: play_picture.Headless = False,
    size: play_picture.Size = "1280x720",
    fps: play_picture.Fps = None,
    shaders: play_picture.Shaders = None,
    quality: play_picture.Quality = None,
    record: play_recording.Record = None,
    share: play_recording.Share = None,
    journal: play_recording.Journal = None,
    status_json: play_recording.StatusJson = None,
    alone: play_alive.Alone = False,
    lead: play_alive.Lead = None,
    standby: play_alive.Standby = None,
    service: play_alive.Service = None,
) -> None:
    """Play a show: music in, dancers on the projector.

    Keys: Space tap, 1 this is the one, B blackout, F full screen, O overlay, S spread; click or drag = attractor,
    with shift = repulsor. Closing the window, Esc in a window or Ctrl-C here ends the show; music from a file begins
    again at its end. Without a screen, 20 s of the show become a film, first-show.mp4.
    """
    import secrets
    from dataclasses import replace

    from rich.console import Console

    from live.app.kernel_warmup import warm_kernels
    from live.app.option_values import (
        audience_address,
        audience_web_address,
        film_file,
        parse_choice,
        parse_endpoint,
        parse_measures,
        parse_number,
        parse_size,
        with_port,
        writable_file,
    )
    from live.app.played import Played
    from live.app.processes.supervised import is_supervised, supervise
    from live.app.services.audience_tls import parse_tls
    from live.app.services.web_key import parse_web
    from live.app.share_names import parse_shares
    from live.app.wish import Wish
    from live.show.patch.patch_search_path import find_patch

    parse_number(bpm, "--bpm", 20, 400)
    parse_number(seconds, "--seconds", 0.1, 7 * 86400)
    parse_number(fps, "--fps", 1, 480)
    parse_number(quality, "--quality", 0, 15)
    parse_number(tempo_share, "--tempo-share", 0.1, 2.0)
    for path, name in ((record, "--record"), (journal, "--journal"), (status_json, "--status-json")):
        writable_file(path, name)
    film_file(record, "--record", never=[audio, patch])
    find_patch(patch)  # a name that nobody knows is told before seconds of loading
    console = Console(stderr=True, highlight=False)
    page = parse_web(
        web, key=web_key, new_key=new_web_key, hosts=web_host or (),
        note=lambda words: console.print(f"note: {words}", style="yellow", markup=False, soft_wrap=True),
    )  # fmt: skip
    played = Played(
        Wish(
            patch=patch,
            audio=audio,
            audio_channel=audio_channel,
            venue=venue,
            bpm=bpm,
            click=click,
            click_channels=click_channels,
            link=parse_choice(link, "--link", "follow", "lead", "off"),
            midi=midi,
            midi_file=midi_file,
            midi_out=midi_out,
            midi_clock_out=midi_clock_out,
            steps=steps,
            seed=seed,
            measures=parse_measures(measures),
            tempo_share=tempo_share,
            osc=parse_endpoint(osc),
            osc_process=bool(osc_process),
            osc_musicians=None if osc_musicians is None else parse_endpoint(osc_musicians, "--osc-musicians"),
            osc_out=tuple(parse_endpoint(each, "--osc-out") for each in osc_out or ()),
            dmx=tuple(dmx or ()),
            psn=psn,
            vmc_out=tuple(vmc_out or ()),
            vmc=tuple(parse_endpoint(with_port(each, 39539), "--vmc") for each in vmc or ()),
            oscquery=None if oscquery is None else parse_endpoint(oscquery, "--oscquery"),
            web=page.where,
            web_key=page.key,
            web_hosts=page.hosts,
            audience=None if audience is None else audience_address(audience),
            audience_link=audience_web_address(audience_link),
            audience_tls=parse_tls(audience_tls),
            audience_secret=b"" if audience is None else secrets.token_bytes(32),
            journal=journal,
            status_json=status_json,
            seconds=seconds,
            record=record,
            share=parse_shares(share),
            operator=operator,
            size=parse_size(size),
            fps=fps,
            shaders=shaders,
            quality=quality,
        ),
        monitor=monitor,
        fullscreen=fullscreen,
        headless=headless,
    )
    if is_supervised(played, alone=alone, machines=lead is not None or standby is not None):
        if osc_process is None:
            played = replace(played, wish=replace(played.wish, osc_process=True))
        supervise(played, lead=lead, standby=standby, service=service)
        return
    warm_kernels(console)  # before anything is imported that has kernels
    from live.app.stage import play_show

    play_show(played.wish, monitor=monitor, fullscreen=fullscreen, headless=headless)
