import threading

from live.control.worker_thread import WorkerThread


def test_work_runs_until_it_is_stopped_and_may_start_again():
    begun, ended = threading.Event(), threading.Event()

    def work() -> None:
        begun.set()
        worker.stopping.wait()

    worker = WorkerThread("work", work, end=ended.set)
    assert worker.stop()  # harmless before the start
    for _ in range(2):
        worker.start()
        assert begun.wait(10.0)
        assert worker.started
        assert worker.stop(timeout=None)
        assert ended.is_set()
        assert not worker.started
        begun.clear()
        ended.clear()


def test_work_is_repeated_and_survives_an_exception():
    calls: list[str] = []
    enough = threading.Event()

    def work() -> None:
        calls.append(threading.current_thread().name)
        if len(calls) == 1:
            raise ValueError("once")
        if len(calls) == 3:
            enough.set()

    worker = WorkerThread("work", work, part="a repeated work", every=1e-3)
    worker.start()
    assert enough.wait(10.0)
    assert worker.stop()
    assert set(calls) == {"work"}


def test_a_thread_that_hangs_is_abandoned():
    hung = threading.Event()
    worker = WorkerThread("work", lambda: hung.wait() and None)
    worker.start()
    assert not worker.stop(timeout=0.0)
    hung.set()
