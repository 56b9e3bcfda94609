"""Command `live layout`: writes control surfaces for tablets."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from live.control.registry.control import Role


KINDS = ("touchosc", "open-stage-control")


def layout(
    kind: Annotated[str, typer.Argument(help="touchosc or open-stage-control.", metavar="touchosc|open-stage-control")],
    out: Annotated[Path, typer.Option(help="The file to write: .tosc or .json.", metavar="FILE", dir_okay=False)],
    patch: Annotated[
        str | None, typer.Option(help="Buttons for the steps, cues, scenes and formations of this patch.")
    ] = None,
    steps: Annotated[Path | None, typer.Option(help="Folder with the patch's recordings.", file_okay=False)] = None,
    role: Annotated[
        str, typer.Option(help="Only the controls that this role may use.", metavar="operator|musician")
    ] = "operator",
    osc: Annotated[
        str, typer.Option(help="The show's OSC address, for Open Stage Control.", metavar="HOST:PORT")
    ] = "127.0.0.1:9010",
) -> None:
    """Write a layout for TouchOSC or Open Stage Control, generated from the control registry.

    In TouchOSC, enter the show's address under Connections > OSC > UDP. Its button "hear the show" makes faders follow
    changes from other sources.
    """
    from rich.console import Console

    from live.app.option_values import parse_endpoint
    from live.base.errors import PersonError
    from live.bridges.layouts.stage_control import session_text
    from live.bridges.layouts.touchosc import write_touchosc
    from live.control.registry.registry import REGISTRY
    from live.control.web.surface import PAD_REACH, make_surface

    if kind not in KINDS:
        raise PersonError(f"there is no layout for {kind!r}", f"give {' or '.join(KINDS)}")
    who: Role = "musician" if role == "musician" else "operator"
    if role != who:
        raise PersonError(f"--role {role}: unknown role", "operator or musician")
    host, port = parse_endpoint(osc, "--osc")
    names: Mapping[str, Sequence[str]] = {}
    reach = PAD_REACH
    if patch is not None:
        names, reach = _patch_names(patch, steps)
    surface = make_surface(REGISTRY, role=who, names=names, reach=reach)
    try:
        if kind == "touchosc":
            write_touchosc(surface, out)
        else:
            out.write_text(session_text(surface, f"{host}:{port}"), encoding="utf-8")
    except OSError as error:
        raise PersonError(f"cannot write --out {out}: {error.strerror}") from None
    count = sum(len(page.widgets) for page in surface.pages)
    console = Console(highlight=False)
    console.print(f"{out}: {count} widgets on {len(surface.pages)} pages", soft_wrap=True, markup=False)
    console.print(f"without a widget: {', '.join(surface.omitted)}", style="dim", soft_wrap=True, markup=False)


def _patch_names(patch: str, steps: Path | None) -> tuple[Mapping[str, Sequence[str]], tuple[float, float]]:
    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.show.patch.patch_search_path import find_patch

    find_patch(patch)  # reports an unknown name before seconds of loading
    warm_kernels(Console(stderr=True))  # before modules with kernels are imported
    from live.app.launch_options import LaunchOptions
    from live.show.desk.completions import completion_names

    loaded = LaunchOptions(patch=patch, steps=steps).load()
    stage = loaded.patch.stage
    return completion_names(loaded.patch, loaded.graph.library.steps), (0.5 * stage.width, 0.5 * stage.depth)
