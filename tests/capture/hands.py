"""A virtual ribbon in the hands of a test, without a port and without real time."""

from georibbon.capture.engine import Engine
from georibbon.capture.plan import CapturePlan
from georibbon.capture.start import open_capture
from georibbon.device.identity import Identity
from georibbon.simulation.settings import (
    LayoutSettings,
    PoseSettings,
    RibbonSettings,
    SimulationSettings,
)
from georibbon.virtual.ribbon import VirtualRibbon
from georibbon.virtual.settings import VirtualSettings


def virtual(seed=1, passes=3, ties=1, sensors=16, poses=12):
    """A virtual ribbon whose clock stands still but for the frames that are drawn."""
    simulation = SimulationSettings(
        seed=seed,
        ribbon=RibbonSettings(sensors=sensors),
        layout=LayoutSettings(passes=passes, ties=ties),
        poses=PoseSettings(plan=poses),
    )
    return VirtualRibbon(VirtualSettings(simulation, pace=0.2), clock=lambda: 0.0)


class Bench:
    """A virtual ribbon, an engine on a session, and what the engine told."""

    def __init__(self, path, plan=None, ribbon=None, auto=True, block=10):
        self.ribbon = ribbon or virtual()
        plan = plan or CapturePlan(poses=12, passes=3, ties=1)
        self.session, self.plan = open_capture(path, Identity(self.ribbon.ribbon, "1.0"), plan)
        self.engine = Engine(self.session, self.plan, auto=auto)
        self.told = []
        self.block = block
        self.engine.observe(self.told.append)

    def pass_time(self, seconds):
        """Feed the frames of so many seconds, in blocks."""
        frames = self.ribbon.frames(round(seconds * self.ribbon.ribbon.rate))
        for start in range(0, len(frames), self.block):
            self.engine.feed(frames[start : start + self.block])

    def do(self, *words, seconds=3.0):
        """Say words to the ribbon, one after another, each with its time."""
        for word in words:
            self.ribbon.do(word)
            self.pass_time(seconds)

    def pose_all(self):
        """Lift the bar and hold it in every planned pose."""
        for number in range(1, self.plan.poses + 1):
            self.do("lift", seconds=0.7)
            self.do(f"pose {number}", seconds=2.5)

    def kinds(self):
        """The kinds of what was told, in order."""
        return [one.kind for one in self.told]

    def last(self, kind):
        """The last happening of a kind."""
        return [one for one in self.told if one.kind == kind][-1]

    def taken(self):
        """What was told as taken, in order."""
        return [one.subject for one in self.told if one.kind == "taken"]
