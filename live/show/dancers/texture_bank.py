"""The recordings that a patch's `[texture]` names, cut at their beats."""

from pathlib import Path

from live.base.errors import PersonError, named
from live.library.capture_material import UNBEATEN, read_material
from live.motion.texture.live_bank import TextureBank
from live.show.patch.patch import Patch
from live.show.patch.patch_file import find_beside


def bank_of(patch: Patch, path: Path) -> TextureBank | None:
    """What dancers of the patch may be textured with, None if it names no recordings.

    PersonError for recordings that are not there, cannot be read, or hold no beat; and for a patch that asks for
    texture and names none.
    """
    section = patch.texture
    if not section.recordings:
        groups = [index for index, group in enumerate(patch.group) if patch.motion_of(group).texture > 0.0]
        if groups:
            raise PersonError(
                f"{path}: motion.texture is {patch.motion_of(patch.group[groups[0]]).texture:g}, and there is nothing "
                "to take it from",
                '[texture] with recordings = ["mocap"], a folder of motion files',
            )
        return None
    places = []
    with named(f"{path}: texture.recordings"):
        for name in section.recordings:
            found = find_beside(name, path)
            if found is None:
                raise PersonError(f"there is no file and no folder {name[:200]!r}", "name it beside the patch")
            places.append(found)
        clips = [clip for clip in read_material(places, fps=section.fps).clips if UNBEATEN not in clip.tags]
        try:
            return TextureBank.of(clips)
        except ValueError as error:
            raise PersonError(
                str(error), "give longer recordings, or say bpm and first_beat_s of them in a TOML file beside them"
            ) from None
