import math
from typing import Annotated, Any

import pydantic
from pydantic import Field, PrivateAttr, ValidationInfo, field_validator, model_validator

from ipoa_mission.autopilot.autopilot import Autopilot, autopilot_named, default_autopilot, registered
from ipoa_mission.autopilot.energy import KAPPA, Battery, PowerModel
from ipoa_mission.autopilot.known_parameters import expect_own, translated
from ipoa_mission.autopilot.learned import LearnedVehicle
from ipoa_mission.autopilot.parameters import SINGLE_MAX, Parameters
from ipoa_mission.autopilot.version import Version
from ipoa_mission.errors import BadInput, hint_of
from ipoa_mission.scenario.section import NotNegative, Positive, Section, one_of

ParameterName = Annotated[str, pydantic.StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,15}$", to_upper=True)]
Single = Annotated[float, Field(ge=-SINGLE_MAX, le=SINGLE_MAX, strict=True)]


def _by_name(value: Any) -> Any:
    return value if isinstance(value, Autopilot) else autopilot_named(value)


AutopilotName = Annotated[
    pydantic.InstanceOf[Autopilot],
    pydantic.BeforeValidator(_by_name),
    pydantic.PlainSerializer(str),
    pydantic.WithJsonSchema(
        {"enum": [str(autopilot) for autopilot in registered()], "type": "string", "default": str(default_autopilot())}
    ),
]


class AirframeSection(Section):
    """A multirotor, as its power model needs it."""

    mass_kg: Positive
    """Take-off mass, battery and payload included."""
    rotors: Annotated[int, Field(ge=1, strict=True)] = 4
    """Rotor discs seen from above; a coaxial pair counts once."""
    rotor_diameter: Positive
    """Diameter of a rotor [m]."""
    drag_area: Positive | None = None
    """Drag coefficient times frontal area [m^2]. Default: 0.05 (mass_kg)^(2/3), a rule of thumb. Measurement in level
    flight at steady airspeed V and tilt: 2 m g tan(tilt) / (rho V^2)."""
    figure_of_merit: Annotated[float, Field(gt=0, le=1 / KAPPA, strict=True)] = 0.6
    """Ideal over actual power of the rotors in hover."""
    drive_efficiency: Annotated[float, Field(gt=0, le=1, strict=True)] = 0.8
    """Efficiency of motors and speed controllers."""
    avionics_w: NotNegative = 10.0
    """Power of everything but the rotors [W]."""

    def build(self) -> PowerModel:
        return PowerModel(
            mass_kg=self.mass_kg,
            disc_area=self.rotors * math.pi * self.rotor_diameter**2 / 4,
            drag_area=self.drag_area if self.drag_area is not None else 0.05 * self.mass_kg ** (2 / 3),
            figure_of_merit=self.figure_of_merit,
            drive_efficiency=self.drive_efficiency,
            avionics_w=self.avionics_w,
        )


class BatterySection(Section):
    """The battery; a plan that lands with less than the reserve is refused."""

    capacity_wh: Positive | None = None
    """Printed energy [Wh]; or use `capacity_mah` and `voltage`."""
    capacity_mah: Positive | None = None
    """Printed charge [mAh]."""
    voltage: Positive | None = None
    """Nominal voltage: 3.7 V times the number of cells in series, or as printed [V]."""
    health: Annotated[float, Field(gt=0, le=1, strict=True)] = 1.0
    """Remaining share of the capacity, as a charger or `SOH` of a smart battery reports it."""
    temperature: Annotated[float, Field(ge=-18, le=60, strict=True)] | None = None
    """Temperature of the battery at take-off [degrees Celsius]. At -18 it gives half of the energy at 27, linear
    between (Battery University, BU-502). Default: warm."""
    reserve: Annotated[float, Field(ge=0, lt=1, strict=True)] = 0.2
    """Share of the available energy that must remain after landing."""
    head_wind: NotNegative = 0.0
    """Additional head wind during the whole flight, on top of `[wind]` [m/s]."""

    _one_capacity = one_of("capacity_wh", "capacity_mah and voltage")

    def build(self) -> Battery:
        wh = self.capacity_wh or (self.capacity_mah or 0.0) / 1000.0 * (self.voltage or 0.0)
        warm = 1.0 if self.temperature is None else (min(self.temperature, 27.0) + 18.0) / 45.0
        return Battery(wh * self.health * (0.5 + warm * 0.5), self.reserve)


class VehicleSection(Section):
    """The vehicle of the mission."""

    autopilot: AutopilotName = Field(default_factory=default_autopilot)
    """The firmware for which the mission is written and its time predicted."""
    firmware_version: str | None = None
    """Its version, like "1.17". Default: the newest with measured flights."""
    unmeasured_version: bool = False
    """Plan, check and fly although no flights of this firmware version were measured."""
    radius: NotNegative = 0.5
    """Radius of a sphere around the whole vehicle [m]."""
    cruise_speed: Positive = 5.0
    """Ground speed along the route [m/s], sent as DO_CHANGE_SPEED."""
    climb_speed: Positive | None = None
    """Default: the autopilot's parameter [m/s]."""
    descent_speed: Positive | None = None
    """Default: the autopilot's parameter [m/s]."""
    parameters: dict[ParameterName, Single] = Field(default_factory=dict)
    """Autopilot parameters that differ from their defaults, in its own names and units. For a landing on high ground a
    plan raises LAND_ALT_LOW, or MPC_LAND_ALT1 and MPC_LAND_ALT2, unless one is given here. With another autopilot
    (`--autopilot`), speeds, accelerations, tilt, acceptance radius and return height are converted. Others are dropped.
    Both are reported."""
    airframe: AirframeSection | None = None
    """Default: energy is estimated by a learned hover power, or not at all."""
    battery: BatterySection | None = None
    """Default: no plan is refused for its energy."""
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
            why = self.autopilot.parameter_table.why_too_fast(getattr(self, key) or 0.0, self.parameters)
            if why:
                raise ValueError(f"{key}: {why}")
        return self

    @model_validator(mode="after")
    def _remark_unknown(self) -> "VehicleSection":
        known = self.autopilot.parameter_names
        hints = {name: hint_of(name, known) for name in self.parameters if name not in known}
        words = (f"vehicle.parameters.{name}: no model uses it; {hint or ''}" for name, hint in hints.items())
        self._remarks = tuple(each.rstrip("; ") for each in words)
        return self

    @property
    def version(self) -> Version | None:
        return None if self.firmware_version is None else Version.parsed(self.firmware_version)

    @property
    def learned(self) -> LearnedVehicle | None:
        """Return the figures of the command line's file."""
        return self._learned

    def learned_as(self, vehicle: LearnedVehicle) -> "VehicleSection":
        copied = self.model_copy()
        copied._learned = vehicle
        return copied

    @property
    def remarks(self) -> tuple[str, ...]:
        return self._remarks

    def remarked(self, words: tuple[str, ...]) -> "VehicleSection":
        copied = self.model_copy()
        copied._remarks += words
        return copied

    def flown_by(self, autopilot: Autopilot) -> "VehicleSection":
        """Convert the parameters to this autopilot's, or drop them."""
        if autopilot is self.autopilot:
            return self
        parameters, words = translated(self.parameters, self.autopilot, autopilot)
        changes = {"autopilot": autopilot, "parameters": parameters, "firmware_version": None}
        copied = self.model_copy(update=changes | {"unmeasured_version": False})
        copied._learned = None
        copied._remarks = tuple(f"vehicle.parameters: {remark}" for remark in words)
        return copied

    def autopilot_parameters(self) -> Parameters:
        """Return the speeds as parameters, then `parameters`."""
        table = self.autopilot.parameter_table
        speeds = {"climb": self.climb_speed, "descent": self.descent_speed}
        given = ((table.by_meaning[f"{way} speed"], speed) for way, speed in speeds.items() if speed is not None)
        changed = {parameter.name: parameter.spelled(speed) for parameter, speed in given}
        return table.overridden(changed, self.parameters)
