import asyncio
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from ipoa_mission.studio.answers import Trouble
from ipoa_mission.studio.flight_desk import FlightDesk
from ipoa_mission.studio.processes import Process
from ipoa_mission.studio.requests import Upload
from ipoa_mission.studio.session import Session
from tests.studio.conftest import MEADOW

WORDS = ("one", "two\n\u2028", "three")


Ask = Callable[[Callable[[Process], Awaitable[None]]], None]


@pytest.fixture(scope="module")
def run() -> Iterator[Ask]:
    """Run a test with one process for all: it needs most of a second to begin."""
    process = Process("tests.studio.echo_worker", Trouble(of="plan", message="it died"))
    with asyncio.Runner() as runner:
        yield lambda test: runner.run(asyncio.wait_for(test(process), 60))
        runner.run(process.close())


def test_requests_are_answered_in_order(run: Ask) -> None:
    async def test(process: Process) -> None:
        heard: list[dict[str, Any]] = []
        asked = [
            process.ask({"job": "echo", "words": words}, heard.append) for words in ("one", "two\n\u2028", "three")
        ]
        await asyncio.gather(*asked)
        assert [answer["words"] for answer in heard] == list(WORDS)

    run(test)


def test_a_refusal_is_told_and_the_worker_lives(run: Ask) -> None:
    async def test(process: Process) -> None:
        heard: list[dict[str, Any]] = []
        await process.ask({"job": "refuse"}, heard.append)
        assert (heard[0]["kind"], heard[0]["message"], heard[0]["hint"]) == ("trouble", "no", "try yes")
        assert await process.ask({"job": "echo", "words": "alive"}, heard.append)
        assert heard[1]["words"] == "alive"

    run(test)


def test_obsolete_requests_are_broken_off(run: Ask) -> None:
    async def test(process: Process) -> None:
        begun = asyncio.Event()
        sleeping = asyncio.create_task(process.ask({"job": "sleep"}, lambda answer: begun.set()))
        await begun.wait()
        sleeping.cancel()
        with pytest.raises(asyncio.CancelledError):
            await sleeping
        heard: list[dict[str, Any]] = []
        await process.ask({"job": "echo", "words": "alive"}, heard.append)
        assert heard[0]["words"] == "alive"

    run(test)


def test_one_that_dies_is_replaced(run: Ask) -> None:
    async def test(process: Process) -> None:
        heard: list[dict[str, Any]] = []
        assert not await process.ask({"job": "die"}, heard.append)
        assert heard.pop()["message"] == "it died"
        assert await process.ask({"job": "echo", "words": "again"}, heard.append)
        assert heard[0]["words"] == "again"

    run(test)


def test_edits_during_the_loading_of_a_plan_are_not_loaded(tmp_path: Path) -> None:
    document: Any = SimpleNamespace(revision=7, path=tmp_path / "meadow.toml")
    orders: list[dict[str, Any]] = []

    class Pilot:
        async def ask(self, order: dict[str, Any], hear: Callable[[dict[str, Any]], None]) -> bool:
            orders.append(order)
            return True

        async def close(self) -> None:
            """It has no process."""

    async def hand_over(file: Path) -> bool:
        document.revision += 1
        return True

    async def whole() -> None:
        desk = FlightDesk(document, lambda message: None)
        desk._process = Pilot()  # type: ignore[assignment]
        desk.upload(Upload(), hand_over, "meadow")
        await asyncio.sleep(0)
        assert desk._task is not None
        await desk._task
        await desk.close()

    asyncio.run(whole())
    assert [order["revision"] for order in orders] == [7]  # a start is refused: another plan is shown


def test_planners_of_a_closed_page_end_after_two_minutes(tmp_path: Path) -> None:
    (tmp_path / "meadow.toml").write_bytes(MEADOW.read_bytes())

    async def whole() -> None:
        session, window = Session(tmp_path / "meadow.toml"), asyncio.Queue[dict[str, Any]]()
        session.join(window)
        while session._quick._process is None:
            await asyncio.sleep(0.05)
        planner = session._quick._process
        await session.look_after(200.0)
        assert planner.returncode is None  # a window is open
        session.leave(window)
        await session.look_after(200.0)
        assert await asyncio.wait_for(planner.wait(), 10.0) != 0
        await session.close()

    asyncio.run(whole())
