"""Commands `live simulate` and `live sim`: collision avoidance on a scenario; simulated band and phones for a show."""

import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import typer

from live.base.errors import PersonError

if TYPE_CHECKING:
    from live.agents.scenarios.metrics import Metrics
    from live.control.registry.control import Role


MAX_COORDINATES = 1 << 25
"""Maximum number of coordinates of a run: a quarter of a gigabyte."""


def simulate(
    scenario: Annotated[
        Path, typer.Argument(help="A scenario (JSON), or the name of a built-in one such as circle-50.")
    ],
    out: Annotated[Path | None, typer.Option(help="Write time, position and arrived (npz).")] = None,
    avoidance: Annotated[
        Literal["predictive", "thesis"],
        typer.Option(help="Collision avoidance: by time to collision, or by the two distances of the thesis."),
    ] = "predictive",
    seed: Annotated[int, typer.Option(help="Random seed.", min=0, max=2**31 - 1)] = 0,
    svg: Annotated[Path | None, typer.Option(help="Draw all paths (SVG).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the metrics as JSON.")] = False,
) -> None:
    """Simulate agents that go from their start positions to their goals without collisions."""
    import numpy as np

    from live.agents.scenarios.metrics import measure
    from live.agents.scenarios.run import simulate as run
    from live.agents.scenarios.run import ticks_in
    from live.app.offline.simulation_input import load_scenario
    from live.app.pictures.simulate_svg import paths_svg
    from live.library.whole_file import write_atomically

    wanted = load_scenario(scenario, seed)
    samples = ticks_in(wanted.duration) + 1
    if 2 * samples * wanted.agent_count > MAX_COORDINATES:
        what = f"{scenario}: duration: {wanted.agent_count:,} agents at {samples:,} ticks need too much memory"
        raise PersonError(what, f"give at most {MAX_COORDINATES // (128 * wanted.agent_count)} s, or fewer agents")
    time, position, arrived = run(wanted, avoidance=avoidance, seed=seed)
    if out is not None:
        packed = io.BytesIO()
        np.savez(packed, time=time, position=position, arrived=arrived)
        write_atomically(packed.getvalue(), out, "--out")
    if svg is not None:
        write_atomically(paths_svg(wanted, time, position).encode(), svg, "--svg")
    print_metrics(measure(wanted, time, position), as_json)


def print_metrics(metrics: "Metrics", as_json: bool) -> None:
    """Print the metrics of a run."""
    figures = metrics.as_json()
    if as_json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name.replace('_', ' '):28}{'-' if value is None else format(value, '.4g')}")


def sim(
    patch: Annotated[str | None, typer.Argument(help="The patch of the show. Default: the first show.")] = None,
    osc: Annotated[str, typer.Option(help="Where the show receives OSC.", metavar="HOST:PORT")] = "127.0.0.1:9010",
    phones: Annotated[int, typer.Option(min=0, max=10000, help="Number of phones.")] = 8,
    rate: Annotated[float, typer.Option(help="Actions per phone and minute.")] = 6.0,
    role: Annotated[str, typer.Option(help="Role of the phones.", metavar="audience|musician|operator")] = "audience",
    nonsense: Annotated[float, typer.Option(help="Share of invalid messages.", metavar="0-1")] = 0.02,
    midi: Annotated[
        str | None, typer.Option(help="Send the band as MIDI clock to this port (see `live devices`).", metavar="NAME")
    ] = None,
    audio: Annotated[
        Path | None,
        typer.Option(help="Only write the band as a sound file for `live play --audio`.", metavar="FILE.wav"),
    ] = None,
    bpm: Annotated[float | None, typer.Option(help="The band's initial tempo. Default: the patch's.")] = None,
    unruly: Annotated[
        float,
        typer.Option(
            help="How often the band stops, plays fills, loses the downbeat or changes tempo; 0: never.", metavar="0-20"
        ),
    ] = 1.0,
    seconds: Annotated[float, typer.Option(help="Duration.")] = 3600.0,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Random seed.")] = 0,
) -> None:
    """Send to a running show: a simulated band that drifts, stops and gets lost, and simulated phones."""
    import threading
    import time

    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.option_values import check_choice, check_range, check_writable, parse_endpoint
    from live.base.errors import PersonError
    from live.show.patch.patch_search_path import find_patch

    find_patch(patch)  # reports an unknown name before seconds of loading
    warm_kernels(Console(stderr=True))  # before modules with kernels are imported
    from live.app.offline.simulation_input import make_band, open_midi_output, write_band_audio
    from live.rehearse.network_sender import UdpSender, clock_pulses, osc_packets, send_all
    from live.rehearse.simulated_players import ArgumentGenerator, SimulatedPlayers
    from live.show.loader import load_show

    check_range(rate, "--rate", 0.0, 6000.0)
    check_range(nonsense, "--nonsense", 0.0, 1.0)
    check_range(unruly, "--unruly", 0.0, 20.0)
    check_range(seconds, "--seconds", 0.1, 7 * 86400.0)
    check_range(bpm, "--bpm", 40.0, 240.0)
    check_choice(role, "--role", "audience", "musician", "operator")
    check_writable(audio, "--audio")
    loaded = load_show(find_patch(patch))
    console = Console(stderr=True, highlight=False)
    clock = loaded.patch.clock
    band = make_band(seed, bpm or clock.bpm, clock.beats_per_measure, unruly)
    if audio is not None:
        write_band_audio(audio, band, seconds, seed, console)
        return
    port = None if midi is None else open_midi_output(midi)
    try:
        outlet = UdpSender(*parse_endpoint(osc))
    except OSError as error:
        raise PersonError(f"--osc {osc}: {error}") from None
    words = ArgumentGenerator(loaded.patch, loaded.graph.library.steps)
    players = SimulatedPlayers(seed, words, count=phones, rate=rate, invalid_share=nonsense, role=cast("Role", role))
    streams: list[Any] = [(osc_packets(players.calls()), outlet.send)]
    if port is not None:
        streams.append((clock_pulses(band), port.send))
    told = f"{phones} phones to {osc}" + ("" if midi is None else f", the band to {midi}")
    console.print(f"{told}; Ctrl-C ends it", style="dim", soft_wrap=True, markup=False)
    begin, ended = time.perf_counter(), threading.Event()
    try:
        send_all(streams, now=lambda: time.perf_counter() - begin, wait=ended.wait, until=seconds)
    finally:
        outlet.close()
        if port is not None:
            port.close()
        console.print(f"{outlet.sent} messages sent, {outlet.failed} failed", style="dim")
