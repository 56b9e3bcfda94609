"""Texts are split into blocks and joined without a loss, and an edit of a block keeps what a person wrote."""

import tomllib

import pytest

from live.document.toml_blocks import EDIT_ERRORS, Block, block_text, edit_block, inserted, joined_tail, split_blocks
from live.show.patch.patch_search_path import PATCHES

TEXT = """# A show.
name = 'quiet'   # in single quotes

# The stage is small.
[stage]
width = 9.50

[[group]] # leaders
name = "ember"
steps = [
  "groove x2",  # twice
  "turn",
]
[group.motion]
larger = 0.2

# Followers.

# They come later.
[[group]]
name = "tide"
"""


def test_all_patches_are_split_and_joined_byte_by_byte() -> None:
    files = sorted(PATCHES.rglob("*.toml"))
    assert len(files) > 10
    for file in files:
        text = file.read_bytes().decode()
        assert "".join(block.text for block in split_blocks(text)) == text


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("last", ["", "\n", "\n\n# the end", "\n\n\n"])
def test_blocks_hold_their_comments_and_sub_tables(end: str, last: str) -> None:
    text = TEXT.rstrip().replace("\n", end) + last.replace("\n", end)
    blocks = split_blocks(text)
    assert "".join(block.text for block in blocks) == text
    assert [(block.names, block.is_entry) for block in blocks] == [
        ((), False), (("stage",), False), (("group",), True), (("group",), True)
    ]  # fmt: skip
    assert blocks[1].text.startswith("# The stage is small.")
    assert blocks[2].values == {"name": "ember", "steps": ["groove x2", "turn"], "motion": {"larger": 0.2}}
    assert blocks[3].text.startswith("# They come later.")  # the comment apart from it ends the table before
    assert blocks[2].parts[1].endswith(f"# Followers.{end}{end}")
    assert all("".join(block.parts) == block.text for block in blocks)


def test_an_edit_changes_its_own_line_only() -> None:
    block = split_blocks(TEXT)[2]
    assert edit_block(block, ("name",), "glow") == block.text.replace('"ember"', '"glow"')
    assert edit_block(block, ("steps", 1), "bow") == block.text.replace('"turn"', '"bow"')
    assert edit_block(block, ("motion", "larger"), 0.3) == block.text.replace("0.2", "0.3")
    root = split_blocks(TEXT)[0]
    assert edit_block(root, ("name",), "loud") == root.text.replace("quiet", "loud")  # comment and quotes stay


def test_lists_of_tables_within_an_entry_grow_and_shrink() -> None:
    block = Block(("improvise",), True, '[[improvise]]\n[[improvise.rule]]\nof = "energy"\nabove = 0.5\n')
    grown = block.with_text(edit_block(block, ("rule", 0), {"of": "loudness", "below": 0.2}, insert=True))
    assert grown.values["rule"] == [{"of": "loudness", "below": 0.2}, {"of": "energy", "above": 0.5}]
    assert grown.with_text(edit_block(grown, ("rule", 0), None)).values == block.values


@pytest.mark.parametrize("path", [("name", "inner"), ("steps", 9), ("motion", "none", 3)])
def test_impossible_paths_raise(path: tuple[str | int, ...]) -> None:
    with pytest.raises(EDIT_ERRORS):
        edit_block(split_blocks(TEXT)[2], path, 1)


def test_new_tables_read_back() -> None:
    values = {
        "a key": '"quotes" and \\ and \u00e9',
        "list": [1, 2.0, [True]],
        "table": {"x": -0.5, "y": "z"},
        "measure": 3,
    }
    assert tomllib.loads(block_text(("midi", "map"), values, is_entry=True))["midi"]["map"] == [values]


@pytest.mark.parametrize("text", [TEXT, TEXT.rstrip(), TEXT.replace("\n", "\r\n"), "", "# nothing yet\n"])
def test_an_inserted_block_can_be_removed_again(text: str) -> None:
    for index in range(len(split_blocks(text))):
        blocks = split_blocks(text)
        first, second = inserted(blocks[index], '[[cue]]\nname = "end"', is_last=index == len(blocks) - 1)
        made = "".join([*(b.text for b in blocks[:index]), first, second, *(b.text for b in blocks[index + 1 :])])
        assert tomllib.loads(made)["cue"] == [{"name": "end"}]
        again = split_blocks(made)
        number = next(number for number, block in enumerate(again) if block.names == ("cue",))
        rest = joined_tail(again[number - 1], again[number])
        kept = "".join([*(b.text for b in again[: number - 1]), rest, *(b.text for b in again[number + 1 :])])
        assert tomllib.loads(kept) == tomllib.loads(text)
        assert [line for line in kept.split() if line] == [line for line in text.split() if line]  # no comment is lost
