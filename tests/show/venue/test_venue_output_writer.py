"""Output warps are written to the venue's file, and the rest of the file stays unchanged."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.render.outputs.output import Output
from live.render.outputs.warp import regular_mesh
from live.show.patch.toml_model import parse_model
from live.show.venue.venue import Venue
from live.show.venue.venue_output_writer import update_output_toml, updated_output_text

WRITTEN = """# our hall
name = "Kaufleuten"   # Zürich

[latency]
projector_ms = 40 # old

[[output]]
name = "left"    # the old one
corners = [[0, 0], [1, 0], [1, 1], [0, 1]]  # by eye
soft_edge = { right = 0.2 }

# the new one
[[output]]
name = "right"
monitor = "2"
"""

BENT = Output("right", corners=((0.1, 0.123456789), (1.0, 0.0), (1.0, 1.0), (0.0, 0.9)))


def test_corners_of_one_output_are_written_and_rest_is_kept():
    text = update_output_toml(WRITTEN, "hall", BENT)
    left, right = tomllib.loads(text)["output"]
    assert right == {"name": "right", "monitor": "2", "corners": [[0.1, 0.12346], [1.0, 0.0], [1.0, 1.0], [0.0, 0.9]]}
    assert left == tomllib.loads(WRITTEN)["output"][0]
    for words in ("# our hall", "# Zürich", "# old", "# the old one", "# by eye", "# the new one"):
        assert words in text
    assert update_output_toml(text, "hall", BENT) == text
    assert update_output_toml(text, "hall", Output("right")) == WRITTEN  # unbent again


def test_mesh_is_written_by_rows_and_read_back():
    rows = [list(row) for row in regular_mesh(3, 2)]
    rows[0][1] = (0.5, -0.04)
    output = replace(BENT, mesh=tuple(map(tuple, rows)))
    text = update_output_toml(WRITTEN, "hall", output)
    assert text.count("\n") == WRITTEN.count("\n") + 5
    read = parse_model(text, "hall.toml", Venue, "venue").output[1].output(Path())
    assert read.mesh == output.mesh
    assert "mesh" not in update_output_toml(text, "hall", replace(output, mesh=regular_mesh(3, 2)))


def test_missing_file_and_output_are_created():
    text = update_output_toml("", "hall", replace(BENT, name="picture"))
    venue = parse_model(text, "hall.toml", Venue, "venue")
    assert venue.name == "hall"
    assert venue.output[0].output(Path()).corners[0] == (0.1, 0.12346)
    more = update_output_toml(text, "hall", replace(BENT, name="other"))
    assert [one["name"] for one in tomllib.loads(more)["output"]] == ["picture", "other"]


def test_unnamed_output_has_the_name_picture():
    text = update_output_toml("[[output]]\nrotation = 180\n", "hall", replace(BENT, name="picture"))
    (one,) = tomllib.loads(text)["output"]
    assert one["rotation"] == 180
    assert one["corners"][0] == [0.1, 0.12346]


def test_invalid_venue_file_is_not_changed(tmp_path):
    path = tmp_path / "hall.toml"
    path.write_text("[[output]]\nrotation = 3\n")
    with pytest.raises(PersonError, match=r"hall.toml, line 2: output.1.rotation"):
        updated_output_text(path, "hall", BENT)
    path.write_text(WRITTEN)
    assert tomllib.loads(updated_output_text(path, "hall", BENT))["output"][1]["corners"][0] == [0.1, 0.12346]
    assert path.read_text() == WRITTEN
