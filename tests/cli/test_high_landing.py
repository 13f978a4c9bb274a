from pathlib import Path

import pytest

from ipoa_mission.link.vehicle import Vehicle
from tests.checks.test_ground import PX4
from tests.cli.conftest import Run, Serve
from tests.routing.test_high_landing import HOME, flight_to_high_ground


def test_fly_refuses_a_vehicle_that_would_touch_down_fast(
    run: Run, autopilot: Serve, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = flight_to_high_ground(PX4)
    flight.write(tmp_path)
    with autopilot(HOME) as link:
        ended = run(f"fly {tmp_path / 'slope.plan'} --link {link} --out {tmp_path}")
        assert ended.code == 1
        assert (
            "error: item 4 (NAV_LAND): at east 200.0, north 0.0 the ground is 12.0 m above home: with the vehicle's "
            "own parameters, without a rangefinder the vehicle touches down at up to 1.5 m/s, not at 0.7" in ended.err
        )
        assert "hint: set the mission's parameters (NAME.params) by `fly --set-params`" in ended.err
        assert "not complete" not in ended.out
        with monkeypatch.context() as lost:  # as by a reboot
            lost.setattr(Vehicle, "set_parameter", lambda *_: None)
            ended = run(f"fly {tmp_path / 'slope.plan'} --link {link} --out {tmp_path} --set-params")
            assert (ended.code, "vehicle touches down at up to 1.5 m/s" in ended.err) == (1, True)
        ended = run(f"fly {tmp_path / 'slope.plan'} --link {link} --out {tmp_path} --set-params")
        assert "MPC_LAND_ALT2 set to 17 (it was 5)" in ended.out
        assert ended.code == 0
