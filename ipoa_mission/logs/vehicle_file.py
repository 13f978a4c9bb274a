import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.errors import BadInput, TooLarge, WrongFormat
from ipoa_mission.files import read_bytes

POWERS = ("hover_power", "square_power", "cube_power", "climb_power", "descent_power", "airspeed", "energy_ratio")
NUMBERS = ("drag", "lag", "lift_delay", "landing_delay", *POWERS)
PLAIN = {"autopilot", "version", "flights"}
UNITS = {
    "drag": "times that of the simulated vehicle",
    "lag": "of rotors and rate loop [s]",
    "lift_delay": "how much later it lifts off [s]",
    "landing_delay": "how much later it disarms after landing [s]",
    "hover_power": "out of the batteries in hover [W]",
    "square_power": "more by the square of the airspeed [W/(m/s)^2]",
    "cube_power": "more by its cube [W/(m/s)^3]",
    "climb_power": "more for climbing [W/(m/s)]",
    "descent_power": "more for coming down [W/(m/s)]",
    "airspeed": "up to which that was seen [m/s]",
    "energy_ratio": "of a flight to what these powers come to",
}
POSITIVE = ("drag", "lag", "hover_power", "airspeed", "energy_ratio")
LIMITS = {"drag": 50.0, "lag": 2.0, "lift_delay": 120.0, "landing_delay": 120.0, "airspeed": 100.0, "energy_ratio": 5.0}
LIMITS |= {name: 100_000.0 for name in POWERS if name not in LIMITS}
MAX_BYTES = 100_000


def write_vehicle(vehicle: LearnedVehicle) -> str:
    """Return the file's text.

    >>> print(write_vehicle(LearnedVehicle(Autopilot.PX4, drag=Learned(1.6, 1.5, 1.7), flights=4)))
    autopilot = "px4"
    flights = 4
    <BLANKLINE>
    [drag]  # times that of the simulated vehicle
    value = 1.6
    low = 1.5
    high = 1.7
    <BLANKLINE>
    """
    lines = [f'autopilot = "{vehicle.autopilot}"']
    lines += [f'version = "{vehicle.version}"'] if vehicle.version else []
    lines += [f"flights = {vehicle.flights}", ""]
    for name in NUMBERS:
        learned: Learned | None = getattr(vehicle, name)
        if learned is not None:
            lines.append(f"[{name}]  # {UNITS[name]}")
            lines += [f"{field.name} = {getattr(learned, field.name):.4g}" for field in fields(Learned)] + [""]
    return "\n".join(lines)


def read_vehicle(path: Path, autopilot: Autopilot | None = None) -> LearnedVehicle:
    """Read a vehicle, of this autopilot if given.

    Raises:
        BadInput: not readable, or not in the format of `write_vehicle`.
    """
    text = read_bytes(path, MAX_BYTES + 1)
    if len(text) > MAX_BYTES:
        raise TooLarge(f"expected a vehicle.toml of at most {MAX_BYTES} bytes", place=path)
    try:
        found = tomllib.loads(text.decode())
    except (ValueError, RecursionError) as error:
        raise WrongFormat(f"expected TOML: {error}", place=path) from error
    for key in found.keys() - PLAIN - set(NUMBERS):
        raise BadInput(f"expected one of {', '.join(sorted([*PLAIN, *NUMBERS]))}", place=f"{path}: {key}")
    return _vehicle(path, found, autopilot)


def _vehicle(path: Path, found: dict[str, Any], autopilot: Autopilot | None) -> LearnedVehicle:
    name = found.get("autopilot")
    known = {one.name: one for one in registered()}
    if name not in known:
        names = " or ".join(f'"{one}"' for one in sorted(known))
        raise BadInput(f"expected {names}, not {name!r:.40}", place=f"{path}: autopilot")
    flies = known[name]
    if autopilot not in (None, flies):
        raise BadInput(f"expected a vehicle with {autopilot}, not with {name}", code="other-autopilot", place=path)
    kinds: dict[str, tuple[type, Any]] = {"version": (str, ""), "flights": (int, 0)}
    plain: dict[str, Any] = {}
    for key, (kind, otherwise) in kinds.items():
        plain[key] = found.get(key, otherwise)
        if type(plain[key]) is not kind:
            raise BadInput(f"expected {kind.__name__}, not {plain[key]!s:.40}", place=f"{path}: {key}")
    numbers = {key: _learned(path, key, found[key]) for key in NUMBERS if key in found}
    return LearnedVehicle(flies, **plain).with_numbers(numbers)


def _learned(path: Path, name: str, given: Any) -> Learned:
    keys = [field.name for field in fields(Learned)]
    if not isinstance(given, dict) or given.keys() != set(keys):
        raise BadInput(f"expected {', '.join(keys)}", place=f"{path}: {name}")
    least, most = (0.0 if name in POSITIVE else -LIMITS[name]), LIMITS[name]
    for key in keys:
        value = given[key]
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not least <= value <= most or (key == "value" and name in POSITIVE and value <= 0):
            raise BadInput(f"expected a number up to {most:g}, not {value!s:.40}", place=f"{path}: {name}.{key}")
    if not given["low"] <= given["value"] <= given["high"]:
        raise BadInput("expected low, value and high in this order", place=f"{path}: {name}")
    return Learned(*(float(given[key]) for key in keys))
