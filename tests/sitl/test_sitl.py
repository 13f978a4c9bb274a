"""Every verb on real autopilots in simulation; each test leaves the vehicle disarmed at home."""

from dataclasses import replace

import pytest

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.commands import Command
from ipoa_mission.geodesy import LocalFrame, apart
from ipoa_mission.link import orders
from ipoa_mission.link.dialogue import until
from ipoa_mission.link.messages import CommandResult
from ipoa_mission.mission.items import FenceCircle, FencePolygon
from tests.sitl.bad_radio import bad_radio
from tests.sitl.simulated import Sitl, interrupt

pytestmark = pytest.mark.sitl
RADIO_LOSS = 0.3
INTERRUPTED_S = 20.0  # wall clock: in the air at any speedup to ten


def flown(sitl: Sitl, words: str = "", link: str | None = None) -> dict[str, object]:
    plan = sitl.write(sitl.mission())
    ended = sitl.run(f"fly {plan} --json {words}", link)
    assert ended.code == 0, ended.err + ended.out
    result = ended.result
    assert result["completed"]
    assert (result["armed"], result["in_air"], result["time_zero"]) == (False, False, "armed")
    seqs = [item["seq"] for item in result["items"]]
    times = [item["done_s"] for item in result["items"]]
    assert seqs == list(range(1, len(sitl.mission().items) + 1))
    assert times == sorted(times)
    assert 0.0 < times[0] < times[-1] == result["flown_s"]
    return result


def bring_home(sitl: Sitl) -> None:
    with sitl.connect() as vehicle:
        result, words = vehicle._run(orders.send(Command.NAV_RETURN_TO_LAUNCH))
        assert result == CommandResult.ACCEPTED, words
        assert vehicle._run(until(lambda: vehicle.state.armed is False, 240.0)), str(vehicle.state)


def test_the_vehicle_is_found(sitl: Sitl) -> None:
    assert [vehicle["autopilot"] for vehicle in sitl.run("scan --json").result] == [sitl.autopilot]  # type: ignore[index]


def test_lists_go_up_come_down_and_go_away(sitl: Sitl) -> None:
    frame = LocalFrame(sitl.home)
    corners = [frame.geodetic(point) for point in ((-80, -80, 0), (90, -80, 0), (90, 90, 0), (-80, 90, 0))]  # type: ignore[arg-type]
    fence = (
        FencePolygon(tuple((c.latitude_deg, c.longitude_deg) for c in corners), True),
        FenceCircle((corners[2].latitude_deg, corners[2].longitude_deg), 5.0, False),
    )
    rally = (replace(frame.geodetic((10.0, 10.0, 0.0)), altitude=15.0),)  # type: ignore[arg-type]
    plan = sitl.write(replace(sitl.mission(), fence=fence, rally=rally))
    sent = sitl.run(f"upload {plan} --json")
    assert sent.code == 0, sent.err
    if sitl.autopilot is Autopilot.ARDUPILOT:
        assert any("FENCE_ENABLE is 0" in remark for remark in sent.result["remarks"])
    got = sitl.run("download back.plan --json").result
    assert (got["items"], got["fence"], got["rally"]) == (len(sitl.mission().items), 2, 1)
    assert sitl.run("clear --json").code == 0
    empty = sitl.run("download none.plan --json").result
    assert (empty["items"], empty["fence"], empty["rally"]) == (0, 0, 0)


def test_a_flight_is_flown_to_its_end_and_again(sitl: Sitl) -> None:
    """The second begins in the mode, and at the item, in which the first has ended."""
    for _ in range(2):
        flown(sitl)


def test_a_flight_begins_at_the_first_item_after_set_current(sitl: Sitl) -> None:
    assert sitl.run(f"upload {sitl.write(sitl.mission())}").code == 0
    assert sitl.run("set-current 4").code == 0
    flown(sitl)


def test_a_flight_that_was_interrupted_begins_anew(sitl: Sitl) -> None:
    plan = sitl.write(sitl.mission())
    with sitl.begin(f"fly {plan}") as running:
        ended = interrupt(running, INTERRUPTED_S)
    assert ended.code == 130, ended.err
    bring_home(sitl)
    flown(sitl)


def test_a_flight_begins_with_another_item_where_that_is_asked_for(sitl: Sitl) -> None:
    plan = sitl.write(sitl.mission())
    ended = sitl.run(f"fly {plan} --from 4 --json")
    assert ended.code == 0, ended.err + ended.out
    assert next(item["seq"] for item in ended.result["items"]) == 4


def test_a_mission_made_for_the_other_firmware_is_refused(sitl: Sitl) -> None:
    other_family = next(family for family in registered() if family is not sitl.autopilot)
    ended = sitl.run(f"upload {sitl.write(replace(sitl.mission(), autopilot=other_family))} --json")
    assert ended.code == 1
    assert "was made for" in ended.result["error"]


def test_a_vehicle_that_stands_elsewhere_is_not_armed(sitl: Sitl) -> None:
    away = LocalFrame(sitl.home).geodetic((40.0, 0.0, 0.0))  # type: ignore[arg-type]
    assert apart(away, sitl.home) == pytest.approx(40.0, abs=0.1)
    ended = sitl.run(f"fly {sitl.write(replace(sitl.mission(), home=away))} --json")
    assert ended.code == 1
    assert "m from the mission's home, and without a scenario" in ended.result["error"]
    assert ended.result["armed"] is False


def test_mavsdk_flies_it_with_the_same_result(sitl: Sitl) -> None:
    pytest.importorskip("mavsdk")
    ours, theirs = flown(sitl), flown(sitl, "--backend mavsdk")
    assert theirs["flown_s"] == pytest.approx(ours["flown_s"], rel=0.06)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_bad_radio_gives_a_flight_or_a_refusal_and_no_false_success(sitl: Sitl, seed: int) -> None:
    """Thirty of a hundred datagrams are lost, each way."""
    if sitl.link.startswith("tcp"):
        pytest.skip("TCP loses nothing")
    with bad_radio(sitl.link, RADIO_LOSS, seed) as link:
        flown(sitl, link=link)
        assert sitl.run("clear", link).code == 0
    with sitl.connect() as vehicle:
        assert vehicle.download().items == ()
