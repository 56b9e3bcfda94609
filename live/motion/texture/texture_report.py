"""Report of a texturing: source of each fragment, joins, foot slide, and level of each band."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.metrics import contact_slide_speeds, skating_frames
from live.motion.skeleton import SKELETON
from live.motion.texture.coordination import coordination_of
from live.motion.texture.frequency_bands import MAX_BANDS, RATE, columns_of, sample_clip, split_bands, tracks_of
from live.motion.texture.texture_corpus import TextureCorpus
from live.motion.texture.texture_settings import TextureSettings
from live.motion.texture.texture_synthesis import TexturedSketch

SHOWN_BANDS = 7


def make_report(
    sketch: Clip, corpus: TextureCorpus, settings: TextureSettings, found: Sequence[TexturedSketch]
) -> dict[str, Any]:
    """Return the report of the paths `found`, at least one, as JSON values."""
    names = SKELETON.names
    joints = [*settings.synthesize, *(one for one in settings.texture if one)]
    cut, parts = found[0].cut, found[0].data_fragments
    return {
        "drive": [names[one] for one in settings.drive],
        "drive_changes": [[time, [names[one] for one in joints]] for time, joints in settings.drive_changes],
        "synthesize": [names[one] for one in settings.synthesize],
        "texture": [names[one] for one in settings.texture],
        "bands": list(settings.bands),
        "match_band": settings.match_band,
        "cut": f"{names[cut // 3]}.{'xyz'[cut % 3]}",
        "candidates": settings.candidates(parts.count),
        "join_weight": settings.join_weight,
        "scale": settings.scale,
        "recordings": [
            {"name": clip.name, "seconds": round(clip.seconds, 3), "fragments": int((parts.clip == n).sum())}
            for n, clip in enumerate(corpus.clips)
        ],
        "charts": {
            names[n]: {"chart": chart.kind, "margin_deg": round(float(np.degrees(chart.margin)), 1)}
            for n, chart in enumerate(corpus.charts)
        },
        "sketch_bands_deg": band_levels(sketch, corpus, joints),
        "foot_slide_mean_sketch": mean_foot_slide(sketch),
        "learnt": corpus.regression(settings).report(settings.spread)
        if settings.learnt and settings.synthesize
        else None,
        "coordination_recordings": [
            {"name": clip.name, **coordination_of(clip, settings.match_band).report()} for clip in corpus.clips
        ],
        "paths": [_path(one, corpus, joints, settings.match_band) for one in found],
    }


def _path(one: TexturedSketch, corpus: TextureCorpus, joints: list[int], match_band: int) -> dict[str, Any]:
    position, _ = forward_kinematics(one.clip.root_position, one.clip.rotation)
    parts = one.data_fragments
    rows = []
    for index, source in enumerate(one.sources.tolist()):
        clip = int(parts.clip[source])
        start = int(corpus.starts[clip])
        rows.append(
            {
                "from_s": round(int(one.fragments.begin[index]) / RATE, 3),
                "to_s": round(int(one.fragments.end[index]) / RATE, 3),
                "recording": corpus.clips[clip].name,
                "fragment": source + 1,
                "its_from_s": round((int(parts.begin[source]) - start) / RATE, 3),
                "its_to_s": round((int(parts.end[source]) - start) / RATE, 3),
                "scale": round(float(one.scales[index]), 3),
            }
        )
    return {
        "joins": one.fragments.count - 1,
        "joins_consecutive": one.consecutive_joins,
        "distance_rad": round(one.distance, 4),
        "largest_jump_joined_rad": round(one.jump, 4),
        "kink_rad_s": {"before": round(one.kinks[0], 4), "after": round(one.kinks[1], 4)},
        "foot_slide_mean": mean_foot_slide(one.clip),
        "skating_ratio": round(float(skating_frames(position, one.clip.sample_rate).mean()), 4),
        "coordination": coordination_of(one.clip, match_band).report(),
        "bands_deg": band_levels(one.clip, corpus, joints),
        "fragments": rows,
    }


def mean_foot_slide(clip: Clip) -> float | None:
    """Return the mean speed over the floor of feet in contact [m/s], None without contacts."""
    position, _ = forward_kinematics(clip.root_position, clip.rotation)
    found = contact_slide_speeds(position, clip.contact, clip.sample_rate)
    return round(float(found.mean()), 4) if len(found) else None


def band_levels(clip: Clip, corpus: TextureCorpus, joints: Sequence[int]) -> list[float]:
    """Return the root mean square of bands 1 to 7 of the angles of `joints` [degrees]."""
    count = min(SHOWN_BANDS, MAX_BANDS)
    tracks = tracks_of(sample_clip(clip), corpus.charts)[:, columns_of(joints)]
    levels = np.sqrt((split_bands(tracks, count)[:count] ** 2).mean(axis=(1, 2)))
    return [round(float(level), 3) for level in np.degrees(levels)]
