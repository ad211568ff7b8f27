"""`georibbon record`: what the virtual ribbon says is in the file, whatever happens on the way."""

import errno
import io
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest

from georibbon.capture import recorder
from georibbon.cli import main, record
from georibbon.device.link import Link
from georibbon.session.counts import parse_csv
from georibbon.session.session import Session
from georibbon.simulation import RibbonSettings, SimulationSettings
from georibbon.virtual.ports import serve_pty, serve_tcp
from georibbon.virtual.ribbon import VirtualRibbon
from georibbon.virtual.settings import VirtualSettings
from waiting import wait_until

RATE = 200.0
KEYS = ["frames", "durable", "lost", "damaged", "stalls", "reconnects", "state", "path"]


def virtual(rate=RATE):
    """A small ribbon, in the air."""
    small = RibbonSettings(sensors=6, length=0.4, rate=rate)
    return VirtualRibbon(VirtualSettings(SimulationSettings(surface="dome", ribbon=small)))


@pytest.fixture
def ribbon():
    """A virtual ribbon on a port; `ribbon.url` is its name."""
    world = virtual()
    with serve_tcp(world, "127.0.0.1", 0) as port:
        world.url = port.url
        yield world


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.csv"


class Lines(io.StringIO):
    """A stream that can be read while it is written."""

    def said(self):
        return self.getvalue().splitlines()


class Here:
    """`georibbon record` in this process, while a script plays with the ribbon beside it."""

    def __init__(self):
        self.out, self.err = Lines(), Lines()
        self.failed = None
        self.over = threading.Event()

    @property
    def lines(self):
        return [json.loads(line) for line in self.out.said() if line.endswith("}")]

    @property
    def last(self):
        return (self.lines or [dict.fromkeys(KEYS, 0)])[-1]

    @property
    def words(self):
        return self.err.getvalue()

    def run(self, *words, script=lambda: None):
        """The exit code; the script ends with an interrupt unless there are --seconds."""

        def play():
            try:
                script()
            except Exception as error:
                self.failed = error
            endless = not any(str(word).startswith("--seconds") for word in words)
            if (endless or self.failed) and not self.over.is_set():
                os.kill(os.getpid(), signal.SIGINT)

        beside = threading.Thread(target=play)
        beside.start()
        with redirect_stdout(self.out), redirect_stderr(self.err):
            code = main(["record", *map(str, words)])
        self.over.set()
        beside.join()
        if self.failed is not None:
            raise self.failed
        return code


@pytest.fixture
def here(monkeypatch):
    monkeypatch.setattr(record, "EVERY", 0.05)
    monkeypatch.setattr(recorder, "RETRY", 0.1)
    return Here()


class Elsewhere:
    """`georibbon record` in a process of its own: its lines as they come."""

    def __init__(self, *words):
        self.lines, self.told = [], []
        self.process = subprocess.Popen(
            [sys.executable, "-m", "georibbon", "record", *map(str, words)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        self._readers = [
            threading.Thread(target=self._read, args=(self.process.stdout, self.lines, json.loads)),
            threading.Thread(target=self._read, args=(self.process.stderr, self.told, str)),
        ]
        for reader in self._readers:
            reader.start()

    @staticmethod
    def _read(stream, into, of):
        for line in stream:
            into.append(of(line))

    def end(self, number=signal.SIGINT):
        """Interrupt it; its exit code."""
        self.process.send_signal(number)
        return self.over()

    def over(self):
        """Wait until it has ended; its exit code."""
        code = self.process.wait(60)
        for reader in self._readers:
            reader.join()
        return code

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.over()
        self.process.stdout.close()
        self.process.stderr.close()

    @property
    def last(self):
        return self.lines[-1] if self.lines else dict.fromkeys(KEYS, 0)

    @property
    def words(self):
        return "".join(self.told)


@pytest.fixture
def elsewhere():
    with ExitStack() as stack:

        def start(*words):
            made = Elsewhere(*words)
            stack.callback(made.close)
            return made

        yield start


def parsed(path, world):
    return parse_csv(path.read_bytes(), world.ribbon.columns, path.name)


def missing(readings, rate=RATE):
    """How many frames are missing between the first and the last, by their times."""
    return int(np.sum(np.rint(np.diff(readings.t) * rate) - 1))


# What is recorded.


def test_so_many_seconds(ribbon, path, here):
    assert here.run(ribbon.url, "--seconds=0.4", "-o", path) == 0
    assert [list(line) for line in here.lines] == [KEYS] * len(here.lines)
    assert len(here.lines) > 2
    assert here.last == {
        "frames": 80, "durable": 80, "lost": 0, "damaged": 0, "stalls": 0, "reconnects": 0,
        "state": "streaming", "path": str(path),
    }  # fmt: skip
    found = parsed(path, ribbon)
    assert found.t.size == 80
    assert np.allclose(found.t, np.arange(80) / RATE, atol=2e-6)
    assert all(line["durable"] <= line["frames"] for line in here.lines)
    assert "streaming: " in here.words
    assert all(line.startswith("georibbon: ") for line in here.err.said())


def test_the_rate_that_is_asked_for(ribbon, path, here):
    assert here.run(ribbon.url, "--seconds=0.4", "--rate=50", "-o", path) == 0
    assert here.last["frames"] == 20
    assert np.allclose(np.diff(parsed(path, ribbon).t), 0.02, atol=2e-6)


def test_what_is_recorded_is_what_the_sensors_say(ribbon, path, here):
    ribbon.do("noise 0")
    ribbon.do("dead A02")
    assert here.run(ribbon.url, "--seconds=0.3", "-o", path) == 0
    counts = parsed(path, ribbon).counts
    columns = ribbon.ribbon.columns
    assert np.all(counts[:, [name.startswith("A02") for name in columns]] == 0)
    first = [columns.index("A01" + axis) for axis in "xyz"]
    gravity = np.linalg.norm(counts[:, first], axis=1) / ribbon.ribbon.sensors[0].counts_per_unit
    assert np.all(np.abs(gravity - 1.0) < 0.2)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_interrupt_is_a_good_end(ribbon, path, here, name):
    def script():
        wait_until(lambda: here.last["durable"])
        os.kill(os.getpid(), getattr(signal, name))

    before = signal.getsignal(getattr(signal, name))
    assert here.run(ribbon.url, "--seconds=1000", "-o", path, script=script) == 0
    assert 0 < here.last["durable"] == here.last["frames"] == parsed(path, ribbon).t.size
    assert here.last["state"] == "streaming"
    assert signal.getsignal(getattr(signal, name)) == before


def test_the_ribbons_own_words_are_told(ribbon, path, here):
    def script():
        wait_until(lambda: here.last["frames"])
        ribbon.do("message battery low")
        wait_until(lambda: "message: battery low" in here.words)

    assert here.run(ribbon.url, "-o", path, script=script) == 0


# Cables.


def test_what_the_cable_loses_is_counted_exactly(ribbon, path, here):
    def script():
        wait_until(lambda: here.last["frames"])
        ribbon.do("drop 0.2")
        ribbon.do("damage 0.2")
        wait_until(lambda: ribbon.sent.dropped > 20 and ribbon.sent.damaged > 20)
        ribbon.do("drop 0")
        ribbon.do("damage 0")
        before = ribbon.sent.frames
        wait_until(lambda: here.last["frames"] + here.last["lost"] > before)

    assert here.run(ribbon.url, "-o", path, script=script) == 0
    sent, found = ribbon.sent, parsed(path, ribbon)
    assert here.last["lost"] == sent.dropped + sent.damaged == missing(found)
    assert here.last["damaged"] == sent.damaged
    assert here.last["frames"] == here.last["durable"] == found.t.size


def test_a_stall_is_told_and_got_over(ribbon, path, here):
    def script():
        wait_until(lambda: here.last["frames"])
        ribbon.do("stall 1.3")
        wait_until(lambda: here.last["state"] == "stalled")
        held = here.last["frames"]
        wait_until(lambda: here.last["frames"] > held + 20)

    assert here.run(ribbon.url, "-o", path, script=script) == 0
    assert "stalled: " in here.words
    assert (here.last["stalls"], here.last["reconnects"]) == (1, 0)
    assert here.last["durable"] == parsed(path, ribbon).t.size


def test_a_cable_that_is_pulled_and_put_back(path, here):
    world = virtual()

    def script():
        for times in (1, 2):
            wait_until(lambda: here.last["state"] == "streaming")
            world.do("unplug")
            wait_until(lambda: here.last["state"] != "streaming")
            world.do("replug")
            wait_until(lambda: here.last["reconnects"] == times)  # noqa: B023 (called at once)
        held = here.last["frames"]
        wait_until(lambda: here.last["frames"] > held + 20)

    with serve_pty(world) as port:
        assert here.run(port.url, "-o", path, script=script) == 0
    assert (here.last["state"], here.last["reconnects"]) == ("streaming", 2)
    assert "disconnected: " in here.words
    found = parsed(path, world)
    assert here.last["durable"] == here.last["frames"] == found.t.size
    assert np.all(np.diff(found.t) > 0)


def test_the_end_may_come_while_the_cable_is_out(path, here):
    world = virtual()

    def script():
        wait_until(lambda: here.last["durable"])
        world.do("unplug")

    with serve_pty(world) as port:
        assert here.run(port.url, "--seconds=0.8", "-o", path, script=script) == 0
    assert here.last["state"] != "streaming"
    assert 0 < here.last["durable"] == parsed(path, world).t.size < 160


# What is refused.


def refused(here):
    assert here.out.getvalue() == ""
    assert here.words.startswith("georibbon: error: ")
    assert here.words.count("\n") == 1
    return here.words


NOWHERE = "/dev/no-such-port"


def test_no_such_port(path, here):
    assert here.run(NOWHERE, "--seconds=1", "-o", path) == 2
    assert NOWHERE in refused(here)
    assert not path.exists()


def test_a_port_of_no_kind(path, here):
    assert here.run("nonsense://x", "--seconds=1", "-o", path) == 2
    assert "nonsense" in refused(here)


def test_another_ribbon(ribbon, path, here):
    assert here.run(ribbon.url, "--seconds=1", "--id=GR-9999", "-o", path) == 2
    told = refused(here)
    assert "GR-9999" in told
    assert ribbon.ribbon.id in told
    assert not path.exists()


@pytest.mark.parametrize("name", ["run.csv", "run.georibbon"])
def test_no_file_is_overwritten(tmp_path, here, name):
    (tmp_path / name).write_text("years of work\n")
    assert here.run(NOWHERE, "--seconds=1", "-o", tmp_path / name) == 2
    assert str(tmp_path / name) in refused(here)
    assert (tmp_path / name).read_text() == "years of work\n"


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["-o", "run.txt"], ".csv or .georibbon"),
        (["-o", "missing/run.csv"], "there is no folder"),
        (["-o", "run.csv", "--seconds=0"], "--seconds"),
        (["-o", "run.csv", "--seconds=nan"], "--seconds"),
        (["-o", "run.csv", "--rate=-1"], "--rate"),
        (["-o", "run.csv", "--baud=0"], "--baud"),
        (["-o", "run.csv", "--baud=fast"], "--baud"),
        ([], "--output"),
    ],
)
def test_words_that_cannot_be_meant(words, named, tmp_path, monkeypatch, here):
    monkeypatch.chdir(tmp_path)
    assert here.run(NOWHERE, *words, script=here.over.wait) == 2
    assert named in refused(here)
    assert list(tmp_path.iterdir()) == []


def test_no_frame_is_no_recording(ribbon, path, here):
    def script():
        wait_until(lambda: here.lines)

    ribbon.do("drop 1")
    assert here.run(ribbon.url, "-o", path, script=script) == 2
    assert "no frame came" in here.err.said()[-1]
    assert not path.exists()


def test_a_ribbon_that_never_sends_a_frame(ribbon, path, here, monkeypatch):
    """With --seconds, nobody needs to be there to end it."""
    monkeypatch.setattr(recorder, "FIRST", 0.1)
    ribbon.do("drop 1")
    assert here.run(ribbon.url, "--seconds=0.2", "-o", path) == 2
    assert "no frame came" in here.err.said()[-1]


@pytest.mark.parametrize("words", [(), ("--seconds=1000",)])
def test_a_link_that_has_ended_is_not_waited_for(ribbon, path, here, monkeypatch, words):
    """However it came to that: its taps are closed, and it says why."""
    links, before = [], Link.recorder
    monkeypatch.setattr(Link, "recorder", lambda link: links.append(link) or before(link))

    def script():
        wait_until(lambda: here.last["durable"])
        links[0].stop()
        here.over.wait()

    assert here.run(ribbon.url, *words, "-o", path, script=script) == 2
    frames = parsed(path, ribbon).t.size
    assert here.err.said()[-1] == (
        f"georibbon: error: {path}: the link ended before the recording: "
        f"{links[0].health().reason}; {frames} frames came until then; go on in another file"
    )
    assert here.last["durable"] == here.last["frames"] == frames > 0


# Sessions.


def test_a_session_holds_the_ribbon_the_frames_and_the_links_doings(tmp_path, here):
    world, path = virtual(), tmp_path / "run.georibbon"

    def script():
        wait_until(lambda: here.last["durable"])
        world.do("message battery low")
        wait_until(lambda: "battery low" in here.words)
        world.do("unplug")
        wait_until(lambda: here.last["state"] != "streaming")
        world.do("replug")
        wait_until(lambda: here.last["reconnects"])
        held = here.last["frames"]
        wait_until(lambda: here.last["durable"] > held + 20)

    with serve_pty(world) as port:
        assert here.run(port.url, "-o", path, script=script) == 0
    assert [file.name for file in tmp_path.iterdir()] == ["run.georibbon"]
    with Session.open(path, read_only=True) as session:
        state = session.state
        assert session.recovery is None
        assert (state.ribbon, state.firmware) == (world.ribbon, world.settings.firmware)
        (stream,) = state.streams
        assert stream.rate == RATE
        found = session.readings(stream.part)
    assert 0 < here.last["durable"] == here.last["frames"] == found.t.size
    assert np.all(np.diff(found.t) > 0)
    doings = [event.detail for event in state.history if event.action == "link"]
    states = [doing["state"] for doing in doings]
    assert states[0] == "opening"
    assert "disconnected" in states
    assert states.index("streaming") < states.index("disconnected")
    assert any("battery low" in doing["reason"] for doing in doings)
    assert doings[-1]["reconnects"] == 1
    assert main(["info", str(path)]) == 0


def test_losses_are_among_the_doings(ribbon, tmp_path, here):
    path = tmp_path / "run.georibbon"

    def script():
        wait_until(lambda: here.last["durable"])
        ribbon.do("drop 0.5")
        wait_until(lambda: here.last["lost"])

    assert here.run(ribbon.url, "-o", path, script=script) == 0
    with Session.open(path, read_only=True) as session:
        doings = [event.detail for event in session.state.history if event.action == "link"]
    assert doings[-1]["lost"] == here.last["lost"] > 0
    assert any(" lost, 0 damaged" in doing["reason"] for doing in doings)


@pytest.mark.parametrize("replaced", [False, True])
def test_a_session_that_is_removed_is_written_anew(ribbon, tmp_path, here, replaced):
    path = tmp_path / "run.georibbon"

    def script():
        wait_until(lambda: here.last["durable"])
        path.unlink()
        if replaced:
            path.write_text("somebody else's")
        wait_until(lambda: "all is on the disk again" in here.words)

    assert here.run(ribbon.url, "-o", path, script=script) == 0
    assert "removed" in here.words
    if replaced:
        assert path.read_text() == "somebody else's"
        assert here.last["path"] != str(path)
    with Session.open(Path(here.last["path"]), read_only=True) as session:
        frames = sum(session.readings(one.part).t.size for one in session.state.streams)
    assert frames == here.last["durable"] == here.last["frames"] > 0


# Disks and readers.


@pytest.fixture
def disk(monkeypatch):
    """A disk that can be full."""

    class Disk:
        full = False

    def flush(descriptor, before=os.fsync):
        if Disk.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        before(descriptor)

    monkeypatch.setattr("os.fsync", flush)
    return Disk


def test_a_full_disk_that_gets_room(ribbon, path, here, disk):
    def script():
        wait_until(lambda: here.last["durable"])
        disk.full = True
        wait_until(lambda: here.last["frames"] > here.last["durable"] + 40)
        assert parsed(path, ribbon).t.size == here.last["durable"]
        disk.full = False
        wait_until(lambda: "all is on the disk again" in here.words)

    assert here.run(ribbon.url, "-o", path, script=script) == 0
    assert here.words.count("cannot be written") == 1
    found = parsed(path, ribbon)
    assert here.last["durable"] == here.last["frames"] == found.t.size
    assert missing(found) == 0


def test_room_that_is_made_at_the_end(ribbon, path, here, disk):
    def script():
        wait_until(lambda: here.last["durable"])
        disk.full = True
        wait_until(lambda: "not on the disk yet" in here.words)
        disk.full = False

    assert here.run(ribbon.url, "--seconds=0.5", "-o", path, script=script) == 0
    assert here.last["durable"] == here.last["frames"] == 100 == parsed(path, ribbon).t.size


def test_a_disk_that_stays_full(ribbon, path, here, disk):
    """Another interrupt ends the waiting; what cannot be written is told, none of it as safe."""

    def script():
        wait_until(lambda: here.last["durable"])
        disk.full = True
        wait_until(lambda: "not on the disk yet" in here.words)
        os.kill(os.getpid(), signal.SIGINT)

    assert here.run(ribbon.url, "--seconds=0.6", "-o", path, script=script) == 2
    assert 0 < here.last["durable"] == parsed(path, ribbon).t.size < here.last["frames"] == 120
    lost = here.last["frames"] - here.last["durable"]
    assert f"{lost} frames could not be written anywhere" in here.err.said()[-1]


def test_another_place_is_taken_in_the_end(ribbon, path, here, monkeypatch, tmp_path):
    monkeypatch.setattr(record, "PATIENCE", 0.1)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def script():
        wait_until(path.exists)
        path.unlink()
        path.write_text("somebody else's")

    assert here.run(ribbon.url, "--seconds=0.6", "-o", path, script=script) == 2
    place = here.last["path"]
    assert f"all of it is in {place}" in here.err.said()[-1]
    assert here.last["durable"] == here.last["frames"] == 120
    assert parsed(Path(place), ribbon).t.size == 120
    assert path.read_text() == "somebody else's"


def test_a_file_that_is_removed_is_written_anew(ribbon, path, here):
    def script():
        wait_until(lambda: here.last["durable"])
        path.unlink()
        wait_until(lambda: "all is on the disk again" in here.words)

    assert here.run(ribbon.url, "-o", path, script=script) == 0
    assert "removed or replaced" in here.words
    found = parsed(path, ribbon)
    assert here.last["durable"] == here.last["frames"] == found.t.size
    assert missing(found) == 0


def test_a_file_that_another_program_empties(ribbon, path, here, monkeypatch, tmp_path):
    """What was in it is lost and told; what comes after is kept, at the end in another place."""
    monkeypatch.setattr(record, "PATIENCE", 0.1)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def script():
        wait_until(lambda: here.last["durable"])
        os.truncate(path, 0)
        wait_until(lambda: "cut the file shorter" in here.words)
        held = here.last["frames"]
        wait_until(lambda: here.last["frames"] > held + 20)

    assert here.run(ribbon.url, "-o", path, script=script) == 2
    place, lost = here.last["path"], here.last["frames"] - here.last["durable"]
    assert here.err.said()[-1].startswith(f"georibbon: error: {place}: another program cut off")
    assert f"{lost} frames may be lost" in here.err.said()[-1]
    assert 20 < here.last["durable"] == parsed(Path(place), ribbon).t.size < here.last["frames"]
    assert path.read_bytes() == b""


def test_nobody_reads_what_is_printed(ribbon, path):
    with subprocess.Popen(
        [sys.executable, "-m", "georibbon", "record", ribbon.url, "--seconds=1.2", "-o", str(path)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as run:  # fmt: skip
        assert json.loads(run.stdout.readline())["frames"]
        run.stdout.close()
        run.stderr.close()
    assert run.returncode == 0
    assert parsed(path, ribbon).t.size == 240


ENDINGS = pytest.mark.parametrize("ending", [".csv", ".georibbon"])


def frames_in(path, world):
    """The frames in a file, as far as it is whole; a session may not have been closed."""
    if path.suffix == ".csv":
        data = path.read_bytes()
        return parse_csv(data[: data.rfind(b"\n") + 1], world.ribbon.columns, path.name)
    with Session.open(path, read_only=True) as session:
        (stream,) = session.state.streams
        return session.readings(stream.part)


@ENDINGS
def test_a_quota_on_the_file(ribbon, tmp_path, elsewhere, ending):
    """The system's own refusal, in the midst of a line."""
    path = tmp_path / f"run{ending}"
    run = elsewhere(ribbon.url, "-o", path)
    wait_until(lambda: run.last["durable"])
    no_larger_than(run, max(file.stat().st_size for file in tmp_path.iterdir()) + 1000)
    wait_until(lambda: run.last["frames"] > run.last["durable"] + 100)
    assert frames_in(path, ribbon).t.size >= run.last["durable"]
    no_larger_than(run, resource.RLIM_INFINITY)
    wait_until(lambda: "all is on the disk again" in run.words)
    assert run.end() == 0
    found = frames_in(path, ribbon)
    assert run.last["durable"] == run.last["frames"] == found.t.size
    assert missing(found) == 0


def no_larger_than(run, size):
    """A quota on every file of a process."""
    resource.prlimit(run.process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


def test_in_two_terminals(tmp_path, elsewhere):
    """`georibbon virtual` in one, `georibbon record` in the other, a faulty cable between."""
    path = tmp_path / "run.georibbon"
    words = ["virtual", "--tcp=127.0.0.1:0", "--sensors=6", "--length=0.4"]
    with subprocess.Popen(
        [sys.executable, "-m", "georibbon", *words, "--drop=0.1", "--damage=0.1"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as ribbon:  # fmt: skip
        url = ribbon.stdout.readline().split()[-1]
        run = elsewhere(url, "--seconds", "1", "-o", path)
        assert run.over() == 0
        ribbon.communicate("quit\n")
    assert run.last["durable"] == run.last["frames"] > 0
    assert run.last["damaged"] > 0
    told = subprocess.run(
        [sys.executable, "-m", "georibbon", "info", path, "--json"],
        stdout=subprocess.PIPE, check=True,
    ).stdout  # fmt: skip
    assert json.loads(told)["frames"] == run.last["frames"]
    gaps = missing(frames_in(path, None), 100.0)
    # What was lost before the first frame and after the last leaves no gap between frames.
    assert 0 < gaps <= run.last["lost"]
    assert run.last["frames"] + gaps <= 100


def test_killed_at_any_moment(tmp_path, elsewhere):
    """Ten recordings killed: what was announced as durable is in each file."""
    random = np.random.default_rng(1)
    paths = [tmp_path / f"run-{i}{ending}" for i in range(5) for ending in (".csv", ".georibbon")]
    with ExitStack() as stack:
        worlds = [virtual(100.0) for _ in paths]
        ports = [stack.enter_context(serve_tcp(world, "127.0.0.1", 0)) for world in worlds]
        runs = [elsewhere(port.url, "-o", path) for port, path in zip(ports, paths, strict=True)]
        for i in random.permutation(len(runs)):
            wait_until(lambda: runs[i].last["durable"])  # noqa: B023 (called at once)
            time.sleep(random.uniform(0.0, 0.2))  # not a wait: the moment is what is drawn
            assert runs[i].end(signal.SIGKILL) == -signal.SIGKILL
    for path, world, run in zip(paths, worlds, runs, strict=True):
        found = frames_in(path, world)
        assert found.t.size >= run.last["durable"] > 0
        assert missing(found, 100.0) == 0
