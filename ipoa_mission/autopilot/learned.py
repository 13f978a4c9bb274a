"""One vehicle's differences from the simulated one, fitted to logs, and their file in TOML."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from ipoa_mission.autopilot.autopilot import Autopilot, registered
from ipoa_mission.errors import BadInput, TooLarge, WrongFormat
from ipoa_mission.files import read_bytes

MAX_BYTES = 100_000


@dataclass(frozen=True)
class Learned:
    """A value and its 90 % interval."""

    value: float
    low: float
    high: float


class Quantity(NamedTuple):
    meaning: str  # with the unit
    most: float = 100_000.0
    positive: bool = False  # else from `-most`


@dataclass(frozen=True)
class LearnedVehicle:
    """Fitted values; None: not determined, the simulator's value holds. Powers as in `energy.PowerCurve`."""

    autopilot: Autopilot
    drag: Annotated[Learned | None, Quantity("times that of the simulated vehicle", 50.0, positive=True)] = None
    lag: Annotated[Learned | None, Quantity("of rotors and rate loop [s]", 2.0, positive=True)] = None
    lift_delay: Annotated[Learned | None, Quantity("how much later it lifts off [s]", 120.0)] = None
    landing_delay: Annotated[Learned | None, Quantity("how much later it disarms after landing [s]", 120.0)] = None
    hover_power: Annotated[Learned | None, Quantity("out of the batteries in hover [W]", positive=True)] = None
    square_power: Annotated[Learned | None, Quantity("more by the square of the airspeed [W/(m/s)^2]")] = None
    cube_power: Annotated[Learned | None, Quantity("more by its cube [W/(m/s)^3]")] = None
    climb_power: Annotated[Learned | None, Quantity("more for climbing [W/(m/s)]")] = None
    descent_power: Annotated[Learned | None, Quantity("more for coming down [W/(m/s)]")] = None
    airspeed: Annotated[Learned | None, Quantity("up to which that was seen [m/s]", 100.0, positive=True)] = None
    energy_ratio: Annotated[
        Learned | None, Quantity("of a flight to what these powers come to", 5.0, positive=True)
    ] = None
    version: str = ""
    flights: int = 0

    def with_numbers(self, numbers: Mapping[str, Learned | None]) -> "LearnedVehicle":
        changes: dict[str, Any] = dict(numbers)
        return replace(self, **changes)

    def value(self, name: str, otherwise: float) -> float:
        learned: Learned | None = getattr(self, name)
        return otherwise if learned is None else learned.value

    def values(self, *names: str) -> dict[str, float]:
        """Return the determined ones."""
        learned = {name: getattr(self, name) for name in names}
        return {name: each.value for name, each in learned.items() if each is not None}


QUANTITIES: Mapping[str, Quantity] = {
    each.name: each.type.__metadata__[0] for each in fields(LearnedVehicle) if hasattr(each.type, "__metadata__")
}
PLAIN = {"version": "", "flights": 0}


def write_vehicle(vehicle: LearnedVehicle) -> str:
    lines = [f'autopilot = "{vehicle.autopilot}"']
    lines += [f'version = "{vehicle.version}"'] if vehicle.version else []
    lines += [f"flights = {vehicle.flights}", ""]
    for name, quantity in QUANTITIES.items():
        learned: Learned | None = getattr(vehicle, name)
        if learned is not None:
            lines.append(f"[{name}]  # {quantity.meaning}")
            lines += [f"{key.name} = {getattr(learned, key.name):.4g}" for key in fields(Learned)] + [""]
    return "\n".join(lines)


def read_vehicle(path: Path, autopilot: Autopilot | None = None) -> LearnedVehicle:
    """Raise BadInput for a file that cannot be read, or of another autopilot (None: any)."""
    import tomllib

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
        kind = type(PLAIN[key])
        if type(value) is not kind:
            raise BadInput(f"expected {kind.__name__}, not {value!s:.40}", place=f"{path}: {key}")
    numbers = {key: _learned(path, key, table[key]) for key in QUANTITIES if key in table}
    return LearnedVehicle(flies, **plain).with_numbers(numbers)


def _learned(path: Path, name: str, numbers: Any) -> Learned:
    keys = [key.name for key in fields(Learned)]
    if not isinstance(numbers, dict) or numbers.keys() != set(keys):
        raise BadInput(f"expected {', '.join(keys)}", place=f"{path}: {name}")
    _, most, positive = QUANTITIES[name]
    least = 0.0 if positive else -most
    for key in keys:
        value = numbers[key]
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not least <= value <= most or (key == "value" and positive and value <= 0):
            raise BadInput(f"expected a number up to {most:g}, not {value!s:.40}", place=f"{path}: {name}.{key}")
    if not numbers["low"] <= numbers["value"] <= numbers["high"]:
        raise BadInput("expected low, value and high in this order", place=f"{path}: {name}")
    return Learned(*(float(numbers[key]) for key in keys))
