"""A show whose pictures remember much, filmed and journalled, for tests of films in parts."""

from rich.console import Console

from live.app.film.show_film import film_show
from live.app.launch_options import LaunchOptions
from live.app.session_audio import AudioChoice
from live.show.journal.journal_reader import read_journal
from live.show.journal.replay import load_journal
from live.show.patch.patch_search_path import PATCHES

SIZE = (48, 27)
PATCH = f"""
name = "Parts"
seed = 3
steps = "{PATCHES / "steps"}"
[clock]
bpm = 150
[camera]
mood = "cinematic"
[look]
world = "water"
gobo_leaves = 0.8
gobo_turn = 0.5
[[group]]
name = "a"
dancers = 4
steps = ["side step", "turn"]
[group.draw]
trails = 0.8
ribbons = 0.7
costume = "skirt"
[[group]]
name = "b"
dancers = 3
steps = ["groove", "jump"]
draw = {{ particles = 0.6 }}
[picture]
passes = ["shadow", "mirror", "focus", "blur", "trails", "vignette"]
[picture.set]
"/dance/pass/trails" = 0.4
"/dance/pass/trails/beats" = 0.2
"/dance/pass/focus" = 0.8
"/dance/pass/blur" = 0.6
"/dance/camera/plan" = 0.3
[sound]
click = true
taps = true
[[title]]
name = "one"
text = "Hello"
measures = 1
[[at]]
measure = 1
beat = 2
call = "/dance/title"
values = ["one"]
[[at]]
measure = 2
beat = 1
call = "/dance/title"
values = ["Zebra", "one"]
"""


def film_first(folder, *, seconds, fps, film="first/%05d.png"):
    """Film the show; return the folder of its pictures, its journal and the show loaded from that."""
    patch = folder / "parts.toml"
    patch.write_text(PATCH)
    options = LaunchOptions(patch=patch, size=SIZE, fps=fps, journal=folder / "a.jsonl")
    path = folder / film
    film_show(options, options.load(), AudioChoice(), path=path, seconds=seconds, console=Console(quiet=True))
    journal = read_journal(folder / "a.jsonl")
    return path.parent, journal, load_journal(journal)


def pictures(folder):
    """The pictures of a folder, by name."""
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.png"))}
