"""What flies the mission, in the scenario: the autopilot, its speeds, and what its energy depends on."""

import math
from typing import Annotated, Any

from pydantic import (
    BeforeValidator,
    Field,
    InstanceOf,
    PlainSerializer,
    PrivateAttr,
    StringConstraints,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from ipoa_mission.errors import BadInput
from ipoa_mission.scenario.section import NotNegative, Positive, Section
from ipoa_mission.vehicles.autopilot import Autopilot, autopilot_named, default_autopilot, registered
from ipoa_mission.vehicles.energy.consumption import Battery
from ipoa_mission.vehicles.energy.power import KAPPA, PowerModel
from ipoa_mission.vehicles.known_parameters import expect_own, translated
from ipoa_mission.vehicles.learned import LearnedVehicle
from ipoa_mission.vehicles.parameters import SINGLE_MAX, Parameters
from ipoa_mission.vehicles.version import Version

ParameterName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,15}$", to_upper=True)]
Single = Annotated[float, Field(ge=-SINGLE_MAX, le=SINGLE_MAX)]


def _by_name(given: Any) -> Any:
    return given if isinstance(given, Autopilot) else autopilot_named(given)


AutopilotName = Annotated[
    InstanceOf[Autopilot],
    BeforeValidator(_by_name),
    PlainSerializer(str),
    WithJsonSchema({"enum": [str(one) for one in registered()], "type": "string", "default": str(default_autopilot())}),
]


class AirframeSection(Section):
    """A multirotor as its power needs it."""

    mass_kg: Positive
    """Take-off mass, battery and payload included."""
    rotors: Annotated[int, Field(ge=1)] = 4
    """Rotor discs seen from above: a coaxial pair is one."""
    rotor_diameter: Positive
    """Diameter of a rotor [m]."""
    drag_area: Positive | None = None
    """Drag coefficient times frontal area [m^2]; left out, 0.05 (mass_kg)^(2/3), a rule of thumb. Measured in level
    flight at a steady airspeed V and tilt it is 2 m g tan(tilt) / (rho V^2)."""
    figure_of_merit: Annotated[float, Field(gt=0, le=1 / KAPPA)] = 0.6
    """Ideal over real power of the rotors in hover."""
    drive_efficiency: Annotated[float, Field(gt=0, le=1)] = 0.8
    """Efficiency of motors and speed controllers."""
    avionics_w: NotNegative = 10.0
    """Power of everything but the rotors [W]."""

    def build(self) -> PowerModel:
        """The airframe itself."""
        return PowerModel(
            mass_kg=self.mass_kg,
            disc_area=self.rotors * math.pi * self.rotor_diameter**2 / 4,
            drag_area=self.drag_area if self.drag_area is not None else 0.05 * self.mass_kg ** (2 / 3),
            figure_of_merit=self.figure_of_merit,
            drive_efficiency=self.drive_efficiency,
            avionics_w=self.avionics_w,
        )


COLD, WARM = (-18.0, 0.5), (27.0, 1.0)  # degrees Celsius, and the share of its capacity that a battery gives there


class BatterySection(Section):
    """The battery; with it, a plan that would land with less than the reserve is refused."""

    capacity_wh: Positive | None = None
    """Energy that is printed on it, or in its place `capacity_mah` and `voltage`."""
    capacity_mah: Positive | None = None
    """Charge that is printed on it."""
    voltage: Positive | None = None
    """Its nominal voltage: 3.7 V times the number of cells in series, or as printed [V]."""
    health: Annotated[float, Field(gt=0, le=1)] = 1.0
    """Share of the capacity that age has left, as a charger or `SOH` of a smart battery tells it."""
    temperature: Annotated[float, Field(ge=COLD[0], le=60)] | None = None
    """Of the battery as it takes off [degrees Celsius]: a cold one gives less, at -18 half of what it gives at 27, and
    in proportion between (Battery University, BU-502). Left out, it is warm."""
    reserve: Annotated[float, Field(ge=0, lt=1)] = 0.2
    """Share of what it gives that must be left after landing."""
    head_wind: NotNegative = 0.0
    """Wind to reckon with besides that under `[wind]`, blowing against the flight all the way [m/s]."""

    @model_validator(mode="after")
    def _one_capacity(self) -> "BatterySection":
        by_charge = self.capacity_mah is not None and self.voltage is not None
        if (self.capacity_wh is not None) == by_charge or (self.capacity_mah is None) != (self.voltage is None):
            raise ValueError("expected either capacity_wh, or capacity_mah and voltage")
        return self

    def build(self) -> Battery:
        """The battery itself, as old and cold as it is."""
        wh = self.capacity_wh or (self.capacity_mah or 0.0) / 1000.0 * (self.voltage or 0.0)
        warm = 1.0 if self.temperature is None else (min(self.temperature, WARM[0]) - COLD[0]) / (WARM[0] - COLD[0])
        given = COLD[1] + warm * (WARM[1] - COLD[1])
        return Battery(wh * self.health * given, self.reserve)


class VehicleSection(Section):
    """What flies the mission."""

    autopilot: AutopilotName = Field(default_factory=default_autopilot)
    """The firmware that the mission is written and its time predicted for."""
    firmware_version: str | None = None
    """Its version, like "1.17"; left out, the newest whose flights were measured."""
    unmeasured_version: bool = False
    """Plan, check and fly although flights of the firmware's version were not measured."""
    radius: NotNegative = 0.5
    """Radius of a ball that holds the whole vehicle [m]."""
    cruise_speed: Positive = 5.0
    """Ground speed along the route [m/s], sent as DO_CHANGE_SPEED."""
    climb_speed: Positive | None = None
    """Left out: what the autopilot's parameters say [m/s]."""
    descent_speed: Positive | None = None
    """Left out: what the autopilot's parameters say [m/s]."""
    parameters: dict[ParameterName, Single] = Field(default_factory=dict)
    """Parameters of the autopilot that differ from its defaults, by its own names and units. For a landing on high
    ground a plan raises LAND_ALT_LOW, or MPC_LAND_ALT1 and MPC_LAND_ALT2, unless one of them is named here. Another
    autopilot (`--autopilot`) has its counterparts of speeds, accelerations, lean, acceptance radius and return height;
    the others are left out. Both is said."""
    airframe: AirframeSection | None = None
    """Left out, energy is estimated by a hover power that was learned, else not."""
    battery: BatterySection | None = None
    """Left out, no plan is refused for its energy."""
    _learned: LearnedVehicle | None = PrivateAttr(None)
    _remarks: tuple[str, ...] = PrivateAttr(())

    @field_validator("parameters")
    @classmethod
    def _of_this_autopilot(cls, parameters: dict[str, float], info: ValidationInfo) -> dict[str, float]:
        try:
            expect_own(parameters, info.data.get("autopilot") or default_autopilot())
        except BadInput as error:
            raise ValueError(f"{error}; {error.hint}" if error.hint else str(error)) from error
        return parameters

    @field_validator("firmware_version")
    @classmethod
    def _with_a_table(cls, text: str | None, info: ValidationInfo) -> str | None:
        try:
            if text is not None:
                (info.data.get("autopilot") or default_autopilot()).tables.expect(Version.parsed(text))
        except BadInput as error:
            raise ValueError(str(error)) from error
        return text

    @model_validator(mode="after")
    def _battery_has_an_airframe(self) -> "VehicleSection":
        if self.battery is not None and self.airframe is None:
            raise ValueError("expected an airframe with the battery")
        return self

    @model_validator(mode="after")
    def _not_too_fast(self) -> "VehicleSection":
        for key in ("cruise_speed", "climb_speed", "descent_speed"):
            if why := self.autopilot.book.why_too_fast(getattr(self, key) or 0.0, self.parameters):
                raise ValueError(f"{key}: {why}")
        return self

    @property
    def version(self) -> Version | None:
        """The firmware's version, where the scenario names one."""
        return None if self.firmware_version is None else Version.parsed(self.firmware_version)

    @property
    def learned(self) -> LearnedVehicle | None:
        """What was learned of the vehicle from its flights, where the command line names a file of it."""
        return self._learned

    def learned_as(self, vehicle: LearnedVehicle) -> "VehicleSection":
        """The same with what was learned of it."""
        copied = self.model_copy()
        copied._learned = vehicle
        return copied

    @property
    def remarks(self) -> tuple[str, ...]:
        """What became of its parameters where another autopilot than the scenario's flies it."""
        return self._remarks

    def flown_by(self, autopilot: Autopilot) -> "VehicleSection":
        """The same vehicle with this autopilot: parameters are translated, or left out."""
        if autopilot is self.autopilot:
            return self
        parameters, words = translated(self.parameters, self.autopilot, autopilot)
        versions = {"firmware_version": None, "unmeasured_version": False}
        changed = {"autopilot": autopilot, **versions, "parameters": parameters}
        copied = self.model_copy(update=changed)
        copied._learned, copied._remarks = None, tuple(f"vehicle.parameters: {said}" for said in words)
        return copied

    def autopilot_parameters(self) -> Parameters:
        """Parameters that differ from the autopilot's defaults: the speeds above, then `parameters`."""
        book = self.autopilot.book
        speeds = ((book.climb, self.climb_speed), (book.descent, self.descent_speed))
        given = {by.name: by.spelled(speed) for by, speed in speeds if speed is not None}
        return book.overridden(given, self.parameters)
