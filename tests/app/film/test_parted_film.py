"""Films of a journal in parts: the same pictures as in the first rendering, whoever draws them and dies."""

import os
import signal
import zlib
from dataclasses import asdict
from queue import SimpleQueue
from typing import ClassVar

import av
import pytest
from rich.console import Console

from live.app.film import film_cluster, film_crew, film_plan, film_worker
from live.app.film.film_crew import LocalCrew, PartResult
from live.app.film.film_plan import FilmPart, film_frames, part_bounds
from live.app.film.film_worker import FilmOrder, FilmWorker, check_needs, needed_files
from live.app.film.parted_film import film_journal
from live.app.film.replay_film import FilmLook
from live.base.errors import PersonError
from live.clock.ticks import FrameGrid
from live.render.film.picture_memory import Reach
from live.show.journal.replay import ReplayStart
from tests.app.film.part_show import SIZE, film_first, pictures
from tests.cli.command import run_live
from tests.cli.test_show_commands import gl_or_skip

FPS, SECONDS = 10.0, 4.5
QUIET = Console(quiet=True)
LOOK = FilmLook(SIZE, FrameGrid(FPS))


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """The first rendering: its folder, journal and show."""
    gl_or_skip()
    return film_first(tmp_path_factory.mktemp("parts"), seconds=SECONDS, fps=FPS)


def decoded(path):
    """All pictures of a film, and its sound."""
    with av.open(str(path)) as film:
        shown = [frame.to_ndarray(format="rgb24").tobytes() for frame in film.decode(video=0)]
    with av.open(str(path)) as film:
        return shown, b"".join(frame.to_ndarray().tobytes() for frame in film.decode(audio=0))


@pytest.mark.long
@pytest.mark.gl
def test_part_has_the_pictures_of_the_first_rendering_and_their_names(filmed, tmp_path):
    first, journal, loaded = filmed
    assert list(pictures(first)) == [f"{frame:05d}.png" for frame in range(45)]
    problems = []
    result = film_journal(
        journal, loaded, tmp_path / "part" / "%05d.png", LOOK, frames=(38, 41), problems=problems, console=QUIET
    )
    assert pictures(tmp_path / "part") == {
        name: pictures(first)[name] for name in ("00038.png", "00039.png", "00040.png")
    }
    assert (result.different, problems) == (0, [])
    assert (tmp_path / "part" / "sound.wav").stat().st_size > 0.29 * 48000 * 4


@pytest.mark.gl
@pytest.mark.long
def test_worker_that_is_killed_costs_its_part_only(filmed, tmp_path, monkeypatch):
    first, journal, loaded = filmed
    killed, started = [], []

    class Killed(LocalCrew):
        def _start(self):
            super()._start()
            started.append(self.workers[-1].process.pid)

        def _act(self, worker, message):
            yield from super()._act(worker, message)
            if "drawn" in message and not killed:
                os.kill(worker.process.pid, signal.SIGKILL)
                killed.append(worker.process.pid)

    monkeypatch.setattr("live.app.film.parted_film.LocalCrew", Killed)
    result = film_journal(
        journal, loaded, tmp_path / "film" / "%05d.png", LOOK, workers=2, problems=[], console=QUIET
    )  # fmt: skip
    assert pictures(tmp_path / "film") == pictures(first)
    assert (len(killed), len(started)) == (1, 3)
    assert (result.measures, result.different) == (2, 0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["film"]  # no parts are left


@pytest.mark.gl
@pytest.mark.long
def test_films_of_one_process_and_of_one_and_two_workers_are_the_same(filmed, tmp_path):
    _, journal, loaded = filmed
    films = []
    for number, options in enumerate(({}, {"workers": 1}, {"workers": 2})):
        film = tmp_path / f"{number}.mp4"
        film_journal(journal, loaded, film, LOOK, problems=[], console=QUIET, **options)
        films.append(decoded(film))
    assert len(films[0][0]) == 45
    assert films[0] == films[1] == films[2]


@pytest.mark.gl
@pytest.mark.long
def test_dask_cluster_draws_the_same_pictures_and_leaves_out_who_cannot(filmed, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the package distributed is not installed")
    first, journal, loaded = filmed
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, dashboard_address=None, host="127.0.0.1", silence_logs=50
    ) as cluster:
        film_journal(
            journal, loaded, tmp_path / "film" / "%05d.png", LOOK, frames=(10, 45),
            cluster=cluster.scheduler_address, problems=[], console=QUIET,
        )  # fmt: skip
        assert pictures(tmp_path / "film") == dict(list(pictures(first).items())[10:])
        own = journal.header | {"music": str(tmp_path / "none.ogg")}
        with pytest.raises(PersonError, match=r"the music .*none\.ogg cannot be read"):
            film_journal(
                type(journal)(journal.path, own), loaded, tmp_path / "b.mp4", LOOK, cluster=cluster.scheduler_address,
                problems=[], console=QUIET,
            )  # fmt: skip
    with pytest.raises(PersonError, match="no Dask scheduler answers"):
        film_journal(
            journal, loaded, tmp_path / "b.mp4", LOOK, cluster="tcp://127.0.0.1:9", problems=[], console=QUIET
        )  # fmt: skip


def test_worker_without_music_or_font_is_refused_by_name(tmp_path):
    music, font = tmp_path / "song.ogg", tmp_path / "own.ttf"
    music.write_bytes(b"song")
    font.write_bytes(b"font")

    class Journal:
        header: ClassVar = {"music": str(music)}

    class Loaded:
        def scene(self):
            from live.base.stage_snapshot import Camera, Scene

            return Scene((8.0, 6.0), Camera(), 1, 22, fonts=(("own", str(font)),))

    needs = needed_files(Journal(), Loaded())
    assert [need[:2] for need in needs] == [("music", str(music)), ("font", str(font))]
    order = FilmOrder("a.jsonl", "film.mp4", SIZE, FPS, needs=needs)
    check_needs(order)
    font.write_bytes(b"another")
    with pytest.raises(PersonError, match=r"the font .*own\.ttf is another file"):
        check_needs(order)
    music.unlink()
    with pytest.raises(PersonError, match=r"the music .*song\.ogg is missing"):
        check_needs(order)
    with pytest.raises(PersonError, match=r"its version is .*, the film's 0\.0\.0"):
        check_needs(FilmOrder("a.jsonl", "film.mp4", SIZE, FPS, version="0.0.0"))
    with pytest.raises(PersonError, match="its kernels are"):
        check_needs(FilmOrder("a.jsonl", "film.mp4", SIZE, FPS, kernels="others"))
    with pytest.raises(PersonError, match=r"the music .*song\.ogg cannot be read"):
        needed_files(Journal(), Loaded())


def test_worker_that_writes_no_message_is_ended_and_heard_of(monkeypatch):
    monkeypatch.setattr(film_worker, "_MODULE", "this")  # a module that prints
    heard = SimpleQueue()
    worker = FilmWorker(FilmOrder("a.jsonl", "film.mp4", SIZE, FPS), heard, threads=1)
    sender, message = heard.get(timeout=20.0)
    worker.close()
    assert sender is worker
    assert message["ended"].startswith("it wrote what is no message: ")


class MadeWorker:
    """A worker that does what a test says."""

    made: ClassVar = []

    def __init__(self, order, heard, *, threads):
        self.part, self.ready, self.heard, self.asked = None, False, heard, []
        self.made.append(self)
        self.tell(ready={})

    def tell(self, **message):
        self.heard.put((self, message))

    def ask(self, part, out, snapshot):
        self.part = part
        self.asked.append((part.number, out.name))

    def close(self):
        self.closed = True


@pytest.fixture
def crew(monkeypatch, tmp_path):
    """Two made workers with three parts of ten frames."""
    monkeypatch.setattr(film_crew, "FilmWorker", MadeWorker)
    MadeWorker.made = []
    made = LocalCrew(FilmOrder("a.jsonl", "film.mp4", SIZE, FPS), tmp_path, 2)
    for number in range(3):
        made.add(FilmPart(number, 10 * number, 10 * number + 10, Reach(0, 0), b"state" if number else None))
    return made


def heard(crew):
    return list(crew.poll(wait=False))


def test_crew_gives_parts_in_order_and_a_lost_one_to_another_worker(crew, tmp_path):
    one, two = MadeWorker.made
    assert heard(crew) == []
    assert (one.asked, two.asked) == ([(0, "0.part")], [(1, "1.part")])
    for _ in range(3):
        one.tell(drawn=1)
    one.tell(ended="killed")
    assert heard(crew) == [1, 1, 1, -3]
    assert one.closed
    assert crew.busy
    two.tell(done=1, before="b", last="l")
    (done,) = [each for each in heard(crew) if isinstance(each, PartResult)]
    assert done == PartResult(1, "b", "l")
    assert MadeWorker.made[2].asked == [(0, "0.part")]  # the lost part comes before later ones
    assert two.asked == [(1, "1.part"), (2, "2.part")]
    assert (tmp_path / "2.snap").read_bytes() == b"state"


def test_crew_gives_up_a_part_whose_workers_die_and_workers_that_do_not_start(crew):
    for _ in range(2):
        heard(crew)
        (worker,) = [each for each in crew.workers if each.part is not None and each.part.number == 0]
        worker.tell(ended="out of memory")
    heard(crew)
    (worker,) = [each for each in crew.workers if each.part is not None and each.part.number == 0]
    worker.tell(ended="out of memory")
    with pytest.raises(PersonError, match="3 processes that drew frames 0 to 9 have ended: out of memory"):
        heard(crew)


def test_crew_gives_the_part_of_a_worker_that_hangs_to_another_one(crew):
    time, (one, two) = [0.0], MadeWorker.made
    crew._now = lambda: time[0]
    crew._since = dict.fromkeys(crew.workers, 0.0)
    assert heard(crew) == []  # both are ready
    time[0] = 1e5
    assert heard(crew) == []  # how fast this machine draws is not known yet
    crew._since = dict.fromkeys(crew.workers, 1e5)
    time[0] += 10.0
    one.tell(drawn=1)
    two.tell(drawn=1)
    assert heard(crew) == [1, 1]
    for _ in range(10):
        time[0] += 20.0
        two.tell(drawn=1)
        assert heard(crew) == [1]
    assert crew.workers == [one, two]
    time[0] += 1.0  # now it is silent for more than ten times 20 s
    assert heard(crew) == [-1]
    assert one.closed
    assert two in crew.workers
    one.tell(ended="killed")  # its last message comes later
    MadeWorker.made[2].tell(drawn=1)
    assert heard(crew) == [1]
    assert MadeWorker.made[2].asked == [(0, "0.part")]


class MadeFuture:
    """What a Dask worker made of a part."""

    def __init__(self, result):
        self.result = result

    def add_done_callback(self, act):
        act(self)


def test_full_disk_of_one_worker_of_a_cluster_costs_its_part_only(monkeypatch, tmp_path):
    """Another worker draws it."""
    asked = []

    class Client:
        def submit(self, run, order, journal, part, at_a_time, *, workers, **how):
            asked.append((part.number, workers))
            return MadeFuture(lambda: draw(run, order, journal, part, at_a_time, workers[0]))

    def draw(run, order, journal, part, at_a_time, worker):
        monkeypatch.setattr(film_cluster, "_this_worker", lambda: worker)
        monkeypatch.setattr(film_cluster, "draw_alone", lambda *asked, **how: drawn(worker, *asked))
        return run(order, zlib.compress(b"journal"), part, at_a_time)

    def drawn(worker, order, part, out, snapshot):
        if worker == "full":
            raise PersonError("the film cannot be written: No space left on device")
        out.write_bytes(b"packets")
        yield {"before": "b", "last": "l", "done": 0}

    monkeypatch.setattr(film_cluster, "_connect", lambda address: Client())
    monkeypatch.setattr(film_cluster.ClusterCrew, "_accept", lambda self, console: {"full": 1, "other": 1})
    journal = tmp_path / "a.jsonl"
    journal.write_bytes(b"journal")
    order = FilmOrder(str(journal), "film.mp4", SIZE, FPS)
    crew = film_cluster.ClusterCrew("", order, (), tmp_path, journal, QUIET)
    crew.add(FilmPart(0, 0, 10, Reach(0, 0)))
    assert heard(crew) == [10, PartResult(0, "b", "l")]
    assert asked == [(0, ["full", "other"]), (0, ["other"])]
    assert crew.file_of(FilmPart(0, 0, 10, Reach(0, 0))).read_bytes() == b"packets"
    assert not crew.busy


def test_worker_of_a_cluster_shares_its_own_processors_among_parts(monkeypatch, tmp_path):
    asked = []

    def draw(order, part, out, snapshot, *, threads):
        asked.append((threads, out.write_bytes(b"packets")))
        yield {"before": "b", "last": "l", "done": 0}

    monkeypatch.setattr(film_cluster, "draw_alone", draw)
    monkeypatch.setattr(film_cluster, "processor_count", lambda: 64)
    order, part = FilmOrder("a.jsonl", "film.mp4", SIZE, FPS), FilmPart(0, 0, 10, Reach(0, 0))
    done = film_cluster.draw_remote(asdict(order), zlib.compress(b"journal"), part, 4)
    assert done == ({"before": "b", "last": "l"}, {"out": b"packets"})
    assert asked[0][0] == 16


def test_refusal_of_a_worker_ends_the_film(crew):
    MadeWorker.made[1].tell(refused="there is no OpenGL")
    with pytest.raises(PersonError, match="there is no OpenGL"):
        heard(crew)


def test_parts_begin_on_the_grid_of_segments():
    for first, end, workers, fps in ((0, 1000, 2, 30.0), (75, 1000, 2, 30.0), (0, 10, 8, 60.0), (0, 40000, 7, 59.94)):
        bounds = part_bounds(first, end, workers, fps)
        assert (bounds[0], bounds[-1]) == (first, end)
        assert all(bound % round(2 * fps) == 0 for bound in bounds[1:-1])
        assert bounds == sorted(set(bounds))
        assert workers * 2 <= len(bounds) or end - first < workers * 4 * 2 * fps


def test_states_are_kept_where_parts_will_probably_start(monkeypatch):
    """So that a worker does not simulate two seconds for nothing before its part."""

    class Taker:
        def __init__(self, show):
            pass

        def capture(self, tick):
            return None if tick == 300 else Taken(tick)

    class Taken:
        def __init__(self, tick):
            self.tick = tick

        def seal(self):
            return self.tick

    monkeypatch.setattr(film_plan, "Snapshotter", Taker)
    states = film_plan._States(ReplayStart(None, 0), [0, 200, 300])
    for tick in range(1, 500):
        states.keep(None, tick)
    assert [states.until(tick) for tick in (100, 199, 200, 300, 301, 430, 499)] == [None, 128, 200, 200, 301, 429, 429]


@pytest.mark.long
@pytest.mark.gl
def test_frames_of_measures_tile_the_show(filmed):
    _, journal, loaded = filmed
    grid, problems = LOOK.grid, []
    assert film_frames(journal, loaded, grid, problems=problems) == (0, 45, 45)
    one = film_frames(journal, loaded, grid, measures=(1, 1), problems=problems)
    rest = film_frames(journal, loaded, grid, measures=(2, None), problems=problems)
    assert (one[0], one[1], rest[1]) == (0, rest[0], 45)
    assert grid.time(rest[0]) == pytest.approx(4 * 60 / 150, abs=2 / FPS)
    assert film_frames(journal, loaded, grid, frames=(40, 99), problems=problems) == (40, 45, 45)
    for said, words in (({"measures": (9, None)}, "no measure 9"), ({"frames": (45, 46)}, "no frame 45; it has 45")):
        with pytest.raises(PersonError, match=words):
            film_frames(journal, loaded, grid, problems=problems, **said)
    last = grid.time(44)  # there is no state after the last tick of the show
    assert (
        FrameGrid(120.0).time(film_frames(journal, loaded, FrameGrid(120.0), problems=problems)[2] - 1) < last + 1 / 64
    )
    assert problems == []


def test_replay_has_as_many_frames_as_the_first_rendering_also_with_several_in_a_tick(tmp_path):
    _, journal, loaded = film_first(tmp_path, seconds=0.505, fps=480.0, film="show.csv")
    grid = FrameGrid(480.0)
    assert grid.first_from(journal.last_tick + 1) == 248
    assert film_frames(journal, loaded, grid, problems=[]) == (0, 243, 243)


@pytest.mark.gl
def test_damaged_line_ends_the_film_and_is_told(filmed, tmp_path):
    _, journal, loaded = filmed
    lines = journal.path.read_text().splitlines(keepends=True)
    path = tmp_path / "b.jsonl"
    path.write_text("".join([*lines[:-1], "{nothing\n", lines[-1]]))
    problems = []
    damaged = type(journal)(path, journal.header)
    frames = film_frames(damaged, loaded, LOOK.grid, problems=problems)
    assert frames[0] == 0
    assert frames[1] == frames[2] <= 45
    assert "not a JSON object" in problems[0]


def test_options_that_do_not_fit_are_refused_before_anything_is_read(tmp_path):
    for words, told in (
        (("--frames", "0:5"), "--frames is for films"),
        (("--workers", "2", "--render", "a.glb"), "--workers: a.glb has the dancers' motion"),
        (("--frames", "0:5", "--from", "2", "--render", "a.mp4"), "--frames and --from, --to both say"),
    ):
        refused = run_live("replay", str(tmp_path / "none.jsonl"), *words)
        assert (refused.returncode, told in refused.stderr) == (2, True), refused.stderr
