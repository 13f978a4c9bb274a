import os
import time
from collections.abc import Mapping

from ipoa_mission.errors import MissionError
from ipoa_mission.studio.flight_answers import State
from ipoa_mission.studio.processes import Answer, Job, JobOrder, Subject, Worker


def echo(order: JobOrder, answer: Answer) -> None:
    answer(State(phase="idle", words=order["words"]))


def refuse(order: JobOrder, answer: Answer) -> None:
    raise MissionError("no", hint="try yes")


def sleep(order: JobOrder, answer: Answer) -> None:
    answer(State(phase="idle", words="sleeping"))
    while True:
        time.sleep(0.01)


def die(order: JobOrder, answer: Answer) -> None:
    os._exit(3)


def jobs(_: object) -> Mapping[str, tuple[Job, Subject]]:
    return {"echo": (echo, "plan"), "refuse": (refuse, "plan"), "sleep": (sleep, "plan"), "die": (die, "plan")}


if __name__ == "__main__":
    print("what a library prints is no answer")
    Worker(jobs).run()
