"""Write and read the file of a learned vehicle: numbers with their bounds, in TOML."""

import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.autopilot.learned import Learned, LearnedVehicle
from ipoa_mission.errors import BadInput, TooLarge, WrongFormat
from ipoa_mission.files import read_bytes


class LearnedQuantity(NamedTuple):
    meaning: str
    most: float = 100_000.0
    is_positive: bool = False


QUANTITIES = {
    "drag": LearnedQuantity("times that of the simulated vehicle", 50.0, is_positive=True),
    "lag": LearnedQuantity("of rotors and rate loop [s]", 2.0, is_positive=True),
    "lift_delay": LearnedQuantity("how much later it lifts off [s]", 120.0),
    "landing_delay": LearnedQuantity("how much later it disarms after landing [s]", 120.0),
    "hover_power": LearnedQuantity("out of the batteries in hover [W]", is_positive=True),
    "square_power": LearnedQuantity("more by the square of the airspeed [W/(m/s)^2]"),
    "cube_power": LearnedQuantity("more by its cube [W/(m/s)^3]"),
    "climb_power": LearnedQuantity("more for climbing [W/(m/s)]"),
    "descent_power": LearnedQuantity("more for coming down [W/(m/s)]"),
    "airspeed": LearnedQuantity("up to which that was seen [m/s]", 100.0, is_positive=True),
    "energy_ratio": LearnedQuantity("of a flight to what these powers come to", 5.0, is_positive=True),
}
PLAIN = {"version": "", "flights": 0}
MAX_BYTES = 100_000


def write_vehicle(vehicle: LearnedVehicle) -> str:
    lines = [f'autopilot = "{vehicle.autopilot}"']
    lines += [f'version = "{vehicle.version}"'] if vehicle.version else []
    lines += [f"flights = {vehicle.flights}", ""]
    for name, quantity in QUANTITIES.items():
        learned: Learned | None = getattr(vehicle, name)
        if learned is not None:
            lines.append(f"[{name}]  # {quantity.meaning}")
            lines += [f"{field.name} = {getattr(learned, field.name):.4g}" for field in fields(Learned)] + [""]
    return "\n".join(lines)


def read_vehicle(path: Path, autopilot: Autopilot | None = None) -> LearnedVehicle:
    text = read_bytes(path, MAX_BYTES + 1)
    if len(text) > MAX_BYTES:
        raise TooLarge(f"expected a vehicle.toml of at most {MAX_BYTES} bytes", place=path)
    try:
        table = tomllib.loads(text.decode())
    except (ValueError, RecursionError) as error:
        raise WrongFormat(f"expected TOML: {error}", place=path) from error
    known = {"autopilot", *PLAIN, *QUANTITIES}
    for key in table.keys() - known:
        raise BadInput(f"expected one of {', '.join(sorted(known))}", place=f"{path}: {key}")
    return _vehicle(path, table, autopilot)


def _vehicle(path: Path, table: dict[str, Any], autopilot: Autopilot | None) -> LearnedVehicle:
    name = table.get("autopilot")
    known = {each.name: each for each in registered()}
    if name not in known:
        names = " or ".join(f'"{each}"' for each in sorted(known))
        raise BadInput(f"expected {names}, not {name!r:.40}", place=f"{path}: autopilot")
    flies = known[name]
    if autopilot not in (None, flies):
        raise BadInput(f"expected a vehicle with {autopilot}, not with {name}", code="other-autopilot", place=path)
    plain: dict[str, Any] = {key: table.get(key, default) for key, default in PLAIN.items()}
    for key, value in plain.items():
        if type(value) is not (kind := type(PLAIN[key])):
            raise BadInput(f"expected {kind.__name__}, not {value!s:.40}", place=f"{path}: {key}")
    numbers = {key: _learned(path, key, table[key]) for key in QUANTITIES if key in table}
    return LearnedVehicle(flies, **plain).with_numbers(numbers)


def _learned(path: Path, name: str, numbers: Any) -> Learned:
    keys = [field.name for field in fields(Learned)]
    if not isinstance(numbers, dict) or numbers.keys() != set(keys):
        raise BadInput(f"expected {', '.join(keys)}", place=f"{path}: {name}")
    _, most, is_positive = QUANTITIES[name]
    least = 0.0 if is_positive else -most
    for key in keys:
        value = numbers[key]
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not least <= value <= most or (key == "value" and is_positive and value <= 0):
            raise BadInput(f"expected a number up to {most:g}, not {value!s:.40}", place=f"{path}: {name}.{key}")
    if not numbers["low"] <= numbers["value"] <= numbers["high"]:
        raise BadInput("expected low, value and high in this order", place=f"{path}: {name}")
    return Learned(*(float(numbers[key]) for key in keys))
