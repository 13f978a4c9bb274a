"""Effect of PX4's commands on the path (1.17.0: MissionBlock, Mission, Commander).

LOITER_TURNS and DO_ORBIT are refused in a mission.
"""

from ipoa_mission.autopilot.commands import Command
from ipoa_mission.autopilot.way_known import WayKnown

WAY_KNOWN = WayKnown(
    why={
        Command.NAV_LOITER_TO_ALT: "it continues within NAV_LOITER_RAD of the place, and changes its height there",
        Command.NAV_VTOL_TAKEOFF: "it is for a VTOL vehicle",
        Command.NAV_VTOL_LAND: "it is for a VTOL vehicle",
        Command.DO_VTOL_TRANSITION: "a multicopter waits forever for a transition to fixed wing",
        Command.DO_SET_HOME: "home changes: heights and returns refer to the new home",
        Command.COMPONENT_ARM_DISARM: "it may stop the motors",
        Command.CONDITION_DELAY: "PX4 from 1.18 on waits there, which is not modeled",
        Command.CONDITION_GATE: "it continues as the vehicle passes the gate, which is not modeled",
    },
)
