"""Clips as text: bit-exact round trip, and damaged text is refused."""

import pytest

from live.library.clip_text import clips_from_text, clips_to_text
from live.show.selection.library_watch import same_clip
from tests.fixtures.made_steps import made_steps


def test_clips_are_bit_exact_at_half_the_size():
    clips = made_steps()
    text = clips_to_text(clips)
    again = clips_from_text(text)
    assert len(again) == len(clips)
    assert all(same_clip(one, other) for one, other in zip(clips, again, strict=True))
    size = sum(clip.clip.rotation.nbytes + clip.clip.root_position.nbytes for clip in clips)
    assert len(text) < 0.5 * size
    assert clips_to_text(clips) == text
    assert clips_from_text(clips_to_text([])) == []


@pytest.mark.parametrize("harm", [lambda text: text[:-40], lambda text: "x" + text[1:], lambda text: "no base64!"])
def test_damaged_text_is_refused(harm):
    with pytest.raises(ValueError, match="damaged"):
        clips_from_text(harm(clips_to_text(made_steps()[:2])))
