from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ipoa_mission import read_mission, read_scenario
from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.failsafe import Contingency
from ipoa_mission.forecast.contingency.contingency_paths import ContingencyPaths
from ipoa_mission.forecast.forecast import Forecast

MISSIONS = Path(__file__).parents[2] / "missions"


@pytest.mark.parametrize("flies", registered())
def test_a_return_keeps_the_same_whichever_autopilot_the_scenario_names(flies: Autopilot) -> None:
    mission = replace(read_mission(MISSIONS / "sitl.plan"), autopilot=flies, parameters={}, firmware_version=None)
    scenario = read_scenario(MISSIONS / "sitl.toml")
    worlds = [
        scenario.model_copy(update={"vehicle": scenario.vehicle.model_copy(update={"autopilot": autopilot})})
        for autopilot in (Autopilot.PX4, Autopilot.ARDUPILOT)
    ]
    ours, theirs = (Forecast(mission, world).cached(ContingencyPaths).samples(Contingency.RTL) for world in worlds)
    assert np.array_equal(ours.slack, theirs.slack)
