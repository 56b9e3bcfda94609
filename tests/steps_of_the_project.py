"""The project's own sketched steps, built once per test run."""

from functools import cache

from live.library.step_folder import sketched_steps
from live.motion.step_clip import StepClip
from tests.places import ROOT

FOLDER = ROOT / "patches" / "steps"


@cache
def project_steps(*names: str) -> list[StepClip]:
    """The step clips of the sketches called `names`, in all their directions and both sides."""
    texts = {f"{name}.toml": (FOLDER / f"{name}.toml").read_text(encoding="utf-8") for name in names}
    return sketched_steps(texts)
