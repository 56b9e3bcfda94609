"""The process that sees: all cameras of a show, and the phones' landmarks, as poses of the show's performers.

Pictures stay in this process. It sends the show `MocapFrame` events, and facts for the status; if it was asked to, it
publishes silhouettes on this machine. A crash of a decoder or a model ends this process only; the show starts another.
"""

import select
import sys
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.clock.time_source import SystemClock
from live.control.camera.camera_eye import CameraEye
from live.control.camera.camera_plan import CameraAddress, CameraPlan
from live.control.camera.frame_source import Frame, FrameSource
from live.control.camera.model_files import DETECTOR, FULL, LITE, checked_model
from live.control.camera.performers import PerformerPose, Performers
from live.control.camera.phone_landmarks import decode_landmarks
from live.control.camera.pose_models import LandmarkModel, PersonDetector
from live.control.camera.seen_person import Person
from live.control.events.event_json import register_events
from live.control.events.events import MocapFrame
from live.control.helper_process import HelperChannel
from live.control.worker_thread import WorkerThread
from live.motion.capture.camera_view import CameraView, calibrate

if TYPE_CHECKING:
    from live.control.camera.silhouette import SilhouetteRings

FACTS_INTERVAL_S: Final = 0.5
_WAIT_S: Final = 0.25
_SPEEDS: Final = 64
_PHONES_FROM: Final = 1000
"""Numbers of phones among the cameras."""
MOST_PHONES: Final = 16
LATEST_S: Final = 1.5
"""Joints of a phone's picture that is older than this [s] are dropped: they would show the past."""

register_events()


class CameraWorker:
    """One camera: reads, looks, passes on. Thread: its own."""

    def __init__(self, index: int, plan: CameraPlan, seer: "CameraProcess") -> None:
        self.index, self.plan, self._seer = index, plan, seer
        self.source = FrameSource(CameraAddress(plan.kind, plan.place))
        self.eye: CameraEye | None = None
        self.view: CameraView | None = None
        self.problem = ""
        """Why the camera's calibration is not used; empty if it is, or there is none."""
        self.looked = 0
        """Pictures that were looked at."""
        self.late = 0
        """Pictures that came while the one before was looked at."""
        self._spent: deque[float] = deque(maxlen=_SPEEDS)
        self._delay: deque[float] = deque(maxlen=_SPEEDS)
        self._rate_since = (0.0, 0)
        self.rate = 0.0
        """Pictures looked at per second, lately."""
        self._worker = WorkerThread(f"eye {plan.name}", self._look_all, part=f"the camera {plan.name}")

    def start(self) -> None:
        """Start to read and to look."""
        self.source.start()
        self._worker.start()

    def stop(self) -> None:
        """Stop."""
        self._worker.stop()
        self.source.stop()

    def _look_all(self) -> None:
        seer, plan = self._seer, self.plan
        screen = np.array(plan.screen, np.float64) if plan.screen else None
        self.eye = CameraEye(
            PersonDetector(checked_model(DETECTOR)), LandmarkModel(checked_model(seer.landmark_model)), seer.most,
            turn_deg=plan.turn_deg, screen=screen,
        )  # fmt: skip
        last = 0
        while not self._worker.stopping.is_set():
            seer.darken_unseen()
            frame = self.source.newest(last, _WAIT_S)
            if frame is None:
                continue
            self.late += frame.number - last - 1 if last else 0
            last = frame.number
            self._look(frame)

    def _look(self, frame: Frame) -> None:
        assert self.eye is not None
        begin = time.perf_counter()
        if self.plan.marks and self.view is None and not self.problem:
            self._calibrate(frame)
        seen = self.eye.look(frame.picture, self._seer.show_time(frame.time))
        self.looked += 1
        self._seer.pass_on(self, seen)
        if self.plan.silhouette:
            self._seer.publish(self, self.eye.people)
        now = time.perf_counter()
        self._spent.append(now - begin)
        self._delay.append(now - frame.time)
        since, count = self._rate_since
        if now - since >= 1.0:
            self.rate, self._rate_since = (self.looked - count) / (now - since), (now, self.looked)

    def _calibrate(self, frame: Frame) -> None:
        marks = np.array(self.plan.marks, np.float64)
        height, width = frame.picture.shape[:2]
        aspect = width / height if self.plan.turn_deg % 180 == 0 else height / width
        try:
            self.view = calibrate(marks[:, :2], marks[:, 2:], aspect)
        except Exception as error:  # marks of a person; the camera is used without them
            self.problem = str(error)

    def facts(self, now: float) -> dict[str, Any]:
        """Return facts for the status."""
        eye = self.eye
        told: dict[str, Any] = {"name": self.plan.name, **self.source.status(), "rate": round(self.rate, 1)}
        if self._spent:
            told["look_ms"] = round(1e3 * float(np.median(self._spent)), 1)
            told["delay_ms"], told["delay_95_ms"] = np.round(1e3 * np.quantile(self._delay, (0.5, 0.95)), 1).tolist()
        if eye is not None:
            told |= {
                "people": len(eye.people), "light": eye.light.word, "upside_down": eye.is_upside_down,
                "still_figures": eye.still_figures, "drawn_left_out": eye.drawn_left_out,
            }  # fmt: skip
        told |= {"late": self.late, "calibrated": self.view is not None}
        return told | ({"calibration": self.problem} if self.problem else {})


class CameraProcess:
    """All cameras of a show. Thread: the process's main one, except where said."""

    def __init__(self, channel: HelperChannel) -> None:
        """Take the plan from the channel."""
        self._channel, plan = channel, channel.plan
        self._clock = SystemClock(plan["origin"])
        cameras = [CameraPlan(**each) for each in plan["cameras"]]
        self.landmark_model = LITE if plan.get("model") == "lite" else FULL
        self.most = max(int(plan["most"]), 1)
        half = plan.get("half")
        self.performers = Performers(plan["performers"], None if half is None else (half[0], half[1]))
        self.workers = [CameraWorker(index, each, self) for index, each in enumerate(cameras)]
        self._silhouettes = _open_rings(cameras, plan["performers"])
        self._lock = threading.Lock()
        self._phones: dict[str, int] = {}
        self._refused = 0
        self.poses = 0
        """Poses sent to the show."""
        self.unsent = 0
        """Poses for which the show had no room."""

    def show_time(self, moment: float) -> float:
        """Return the show time [s] of a moment on the clock of `time.perf_counter`. Thread: any."""
        return self._clock.now() - (time.perf_counter() - moment)

    def pass_on(self, worker: CameraWorker, seen: list[Any]) -> None:
        """Send the show the poses of people whom a camera has seen. Thread: any."""
        with self._lock:
            try:
                self._send(self.performers.update(worker.index, worker.view, seen, self._clock.now()))
            except ValueError:  # what the model made of this picture is no body
                self._refused += 1

    def publish(self, worker: CameraWorker, people: list[Person]) -> None:
        """Publish the silhouettes of people whom a camera has just seen. Thread: any."""
        if self._silhouettes is None:
            return
        with self._lock:
            names = [self.performers.name_of(worker.index, each.number, each.time) for each in people]
        for name, person in zip(names, people, strict=True):
            if name is not None:
                self._silhouettes.show(name, worker.index, person, self._clock.now())

    def darken_unseen(self) -> None:
        """Make the silhouettes black of those whom no camera sees any more. Thread: any."""
        if self._silhouettes is not None:
            self._silhouettes.darken_unseen(self._clock.now())

    def _send(self, poses: list[PerformerPose]) -> None:
        events = tuple(
            MocapFrame(time=each.time, source="camera", performer=each.name, pose=each.packed) for each in poses
        )
        if events:
            self.poses += len(events)
            self.unsent += not self._channel.send(events)

    def run(self) -> None:
        """Work until the show closes the channel."""
        for worker in self.workers:
            worker.start()
        told = 0.0
        try:
            while not self._channel.closed:
                for packet in self._channel.packets():
                    self.take(packet)
                now = time.perf_counter()
                if now - told >= FACTS_INTERVAL_S:
                    told = now
                    self._channel.send_facts(self.facts())
                    self.darken_unseen()
                select.select([self._channel.socket], [], [], FACTS_INTERVAL_S)
        finally:
            for worker in self.workers:
                worker.stop()
            if self._silhouettes is not None:
                self._silhouettes.close()

    def take(self, packet: Any) -> None:
        """Take a packet of the show: a kind and its values."""
        match packet:
            case ("names", tuple() | list() as names):
                with self._lock:
                    self.performers.rename([str(each) for each in names])
                if self._silhouettes is not None:
                    self._silhouettes.rename([str(each) for each in names])
            case ("exchange", str() as first, str() as second):
                with self._lock:
                    self.performers.exchange(first, second)
            case ("drawn", float() as when, bytes() as joints):
                figures = np.frombuffer(joints, np.float32).reshape(-1, 12, 2).astype(np.float64)
                for worker in self.workers:
                    if worker.eye is not None:
                        worker.eye.draw(when, figures)
            case ("phone", str() as phone, str() as performer, bytes() as data):
                self._take_phone(phone, performer, data)
            case _:
                self._refused += 1

    def _take_phone(self, phone: str, performer: str, data: bytes) -> None:
        try:
            told = decode_landmarks(data)
        except ValueError:
            self._refused += 1
            return
        if phone not in self._phones and len(self._phones) >= MOST_PHONES:
            self._refused += 1
            return
        camera = self._phones.setdefault(phone, _PHONES_FROM + len(self._phones))
        now = self._clock.now()
        if now - told.time > LATEST_S:
            self._refused += 1
        elif told.landmarks is not None:
            with self._lock:
                try:
                    self._send(self.performers.update_named(camera, performer, told.landmarks, now))
                except ValueError:
                    self._refused += 1

    def facts(self) -> dict[str, Any]:
        """Return facts for the status."""
        now = self._clock.now()
        with self._lock:
            seen = {name: round(now - last, 2) for name, last in self.performers.seen.items()}
            outside, nameless = self.performers.outside, self.performers.without_name
        shared = self._silhouettes
        published = {} if shared is None else {"silhouettes": shared.names, "silhouette_problem": shared.problem}
        return published | {
            "cameras": [worker.facts(now) for worker in self.workers], "phones": len(self._phones),
            "poses": self.poses, "unsent": self.unsent, "seen_s_ago": seen, "outside": outside,
            "without_name": nameless, "refused": self._refused,
        }  # fmt: skip


def _open_rings(cameras: list[CameraPlan], performers: list[str]) -> "SilhouetteRings | None":
    """Open the rings for silhouettes if a camera is to publish any: only then is their kernel loaded."""
    if not any(each.silhouette for each in cameras):
        return None
    from live.control.camera.silhouette import SilhouetteRings

    return SilhouetteRings(performers)


def main() -> None:
    """Run the process; the channel's name is the first argument."""
    channel = HelperChannel(sys.argv[1])
    CameraProcess(channel).run()


if __name__ == "__main__":
    main()
