"""A machine that stands by and lacks what the leader dances says so."""

import json
from pathlib import Path

import pytest

from live.app.processes.remote_standby import apply_log
from live.base.errors import PersonError
from live.control.events.event_json import event_to_json
from live.control.events.events import PatchChanged
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import patch_version
from live.supervisor.state_follower import StateFollower
from tests.show.made_show import GRAPH, PATCH


def test_other_steps_than_the_leader_s_are_named_and_end_it_as_a_person_s_error():
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
    header = {"journal": 2, "origin": 0.0, **loaded.header(loaded.start(seed=1), tempo=None)}
    following = StateFollower(loaded)
    following.add_line(json.dumps(header | {"steps_hash": "0" * 16}))
    following.add_line(json.dumps({"tick": 3}))
    with pytest.raises(PersonError, match="cannot run here") as raised:
        apply_log(following)
    assert "same steps" in str(raised.value.remedy)


def told(patch: str, *later: str) -> StateFollower:
    """A machine with the made show's patch, told of a show of another one that was edited later."""
    loaded, other = (LoadedShow(Path("test.toml"), parse_patch(text, "test.toml"), GRAPH) for text in (PATCH, patch))
    following = StateFollower(loaded)
    following.add_line(json.dumps({"journal": 2, "origin": 0.0, **other.header(other.start(seed=1), tempo=None)}))
    for text in later:
        edited = parse_patch(text, "test.toml").model_dump_json()
        event = PatchChanged(time=0.0, source="patch", patch=edited, version=patch_version(edited))
        following.add_line(json.dumps({"tick": 2, "event": event_to_json(event)}))
    following.add_line(json.dumps({"tick": 3}))
    return following


OTHER = PATCH.replace('steps = ["glide", "sway", "spin"]', 'steps = ["spin"]')


def test_another_patch_than_the_leader_s_is_named_and_never_taken_over():
    assert OTHER != PATCH
    with pytest.raises(PersonError, match=r"plays another show.*different: group \(") as raised:
        apply_log(told(OTHER))
    assert "same patch" in str(raised.value.remedy)


def test_a_patch_that_the_leader_has_edited_since_may_be_here_as_it_was_or_as_it_is():
    for begun, later in ((PATCH, [OTHER]), (OTHER, [PATCH])):
        assert told(begun, *later).show_mismatch() is None
