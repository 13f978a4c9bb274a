import json
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot
from ipoa_mission.geodesy import Geodetic, LocalFrame
from ipoa_mission.link.connect import connect
from ipoa_mission.link.dialogue import NoAnswer
from ipoa_mission.link.vehicle import Vehicle
from ipoa_mission.mission.items import Item, Mission, change_speed, return_to_launch, takeoff, waypoint
from ipoa_mission.mission.mission_io import write_mission

#: A square beside home [m]: east, north, up.
SQUARE = ((0.0, 0.0, 12.0), (25.0, 0.0, 12.0), (25.0, 25.0, 15.0), (0.0, 25.0, 12.0))


@dataclass(frozen=True)
class Ended:
    code: int
    out: str
    err: str

    @property
    def result(self) -> dict[str, Any]:
        result: dict[str, Any] = json.loads(self.out)
        return result


@dataclass
class Sitl:
    """A running simulation, and the command line pointed at it."""

    autopilot: Autopilot
    link: str
    folder: Path
    home: Geodetic = field(init=False)

    def connect(self, link: str | None = None) -> Vehicle:
        """Connect; wait for a simulation that has just been started."""
        until = time.monotonic() + 60.0
        while True:
            try:
                return connect(link or self.link)
            except NoAnswer:
                if time.monotonic() > until:
                    raise

    def wait_for_home(self) -> Geodetic:
        until = time.monotonic() + 120.0
        while time.monotonic() < until:
            with self.connect() as vehicle:
                if (home := vehicle.home()) is not None and home.latitude_deg:
                    return home
            time.sleep(1.0)
        raise TimeoutError(f"{self.autopilot} does not say where its home is")

    def begin(self, words: str, link: str | None = None) -> "subprocess.Popen[str]":
        command = [sys.executable, "-m", "ipoa_mission", *shlex.split(words), "--link", link or self.link]
        return subprocess.Popen(
            command,
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell's background jobs ignore it
        )

    def run(self, words: str, link: str | None = None, seconds: float = 400.0) -> Ended:
        with self.begin(words, link) as running:
            out, err = running.communicate(timeout=seconds)
        return Ended(running.returncode, out, err)

    def mission(self, items: tuple[Item, ...] | None = None) -> Mission:
        frame = LocalFrame(self.home)
        places = [(frame.geodetic(point), point[2]) for point in map(list, SQUARE)]  # type: ignore[arg-type]
        legs = (waypoint(place, up) for place, up in places[1:])
        return Mission(
            self.home,
            items or (takeoff(self.home, 12.0), change_speed(4.0), *legs, return_to_launch()),
            self.autopilot,
            cruise_speed=4.0,
        )

    def write(self, mission: Mission, name: str = "square.plan") -> Path:
        write_mission(mission, self.folder / name)
        return self.folder / name


def interrupt(running: "subprocess.Popen[str]", after_s: float) -> Ended:
    time.sleep(after_s)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60.0)
    return Ended(running.returncode, out, err)
