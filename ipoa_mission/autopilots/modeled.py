"""Which versions of the autopilots the models are of."""

import re

from ipoa_mission.autopilots.vehicle import Autopilot

#: The oldest version whose habits the models have, and its name.
OLDEST = {Autopilot.ARDUPILOT: ("ArduCopter", (4, 0)), Autopilot.PX4: ("PX4", (1, 13))}


def beyond_the_model(autopilot: Autopilot, version: str) -> str | None:
    """What to say of times that are estimated for a version; None where the model is of it.

    >>> beyond_the_model(Autopilot.PX4, "1.15.0-dev")
    >>> beyond_the_model(Autopilot.ARDUPILOT, "3.5.7")
    'flown by ArduCopter 3.5.7; the model is of 4.0 and later, and its times may be off'
    """
    name, oldest = OLDEST[autopilot]
    least = ".".join(map(str, oldest))
    numbers = re.match(r"(\d+)\.(\d+)", version)
    if numbers is None:
        return f"the log does not say which {name} flew it; the model is of {least} and later"
    if tuple(map(int, numbers.groups())) >= oldest:
        return None
    return f"flown by {name} {version}; the model is of {least} and later, and its times may be off"
