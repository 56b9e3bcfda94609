"""`live steps enrich`: every sketched step gets textured versions, made of motion capture."""

from pathlib import Path

from rich.console import Console

from live.app.whole_file import write_whole
from live.base.errors import PersonError
from live.cli.steps.steps_library import folders
from live.library.capture_material import read_material
from live.library.enriching import Enriched, Upper, enrich, material_for
from live.library.recording_file import read_step_files
from live.library.sketch_folder import sketched_steps
from live.library.step_folder import plain_name
from live.library.textured import textured_beside, textured_text
from live.motion.step_clip import StepClip
from live.motion.texture.texture_settings import Wish


def enrich_library(
    library: Path | None,
    places: list[Path],
    steps: list[str],
    wish: Wish,
    upper: Upper,
    *,
    fps: float | None,
    remove: bool,
) -> None:
    """Write the textured versions of every sketched step, or of `steps`, beside it; or take them away."""
    console = Console(highlight=False, soft_wrap=True)
    sketches = _sketches(library, steps)
    if remove:
        _remove(console, sketches)
        return
    if not places:
        raise PersonError("there is no motion capture to take texture from", "--with DIR_OR_FILES")
    recorded = read_material(places, fps=fps)
    for words in recorded.passed:
        console.print(f"passed over: {words}", style="yellow", markup=False)
    own = {file: sketched_steps({file: text}) for file, text in sketches.items()}
    everything = [step for clips in own.values() for step in clips if not step.mirrored]
    material = material_for([one.clip for one in recorded.clips], everything)
    seconds = sum(clip.seconds for clip in material.clips)
    console.print(f"{len(material.clips)} recordings, {seconds:.0f} s", markup=False)
    facts = {"with": [str(place) for place in places], "bands": list(wish.bands), "match_band": wish.match_band}
    for file, clips in own.items():
        try:
            made = enrich(clips, material, wish, upper)
        except PersonError as error:
            raise PersonError(f"{file}: {error.message}", error.remedy) from None
        mirror = any(step.mirrored for step in clips)
        text = textured_text(made.clips, sketches[file], facts | {"mirror": mirror})
        size = write_whole(text.encode(), textured_beside(Path(file)), "--library")
        _say(console, clips, made, size)
    console.print("see one: live steps show STEP; taken away: live steps enrich --remove", style="dim")


def _sketches(library: Path | None, wanted: list[str]) -> dict[str, str]:
    """Sketch texts by file name, of all folders or of the steps that were named."""
    found: dict[str, str] = {}
    for folder in folders(library):
        found |= read_step_files(folder).sketches
    if not found:
        raise PersonError("there is no sketched step to texture", "sketches are TOML files: docs/steps.md")
    if not wanted:
        return found
    names = {plain_name(sketched_steps({file: text})[0].step): file for file, text in found.items()}
    unknown = [one for one in wanted if plain_name(one) not in names]
    if unknown:
        raise PersonError(f"--step {unknown[0][:60]!r}: no sketch is called so", ", ".join(sorted(names)[:20]))
    return {names[plain_name(one)]: found[names[plain_name(one)]] for one in wanted}


def _remove(console: Console, sketches: dict[str, str]) -> None:
    gone = 0
    for file in sketches:
        path = textured_beside(Path(file))
        if path.is_file():
            try:
                path.unlink()
            except OSError as error:
                raise PersonError(f"{path}: cannot be removed: {error.strerror}", "remove it by hand") from None
            gone += 1
    console.print(f"{gone} files of textured steps removed", markup=False)


def _say(console: Console, clips: list[StepClip], made: Enriched, size: int) -> None:
    how = "made" if made.made else "textured"
    console.print(
        f"{clips[0].step}: {len(made.clips)} versions, upper body {how}, matched to {made.distance:.3f} rad, "
        f"{made.free:.0%} of joins as recorded, {made.kept:.0%} of it left at measure lines, {size // 1000} kB",
        markup=False,
    )
