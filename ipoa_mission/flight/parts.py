"""The files of a flight that is flown in parts, a battery each: NAME-1.plan and so on, and NAME.json about all."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ipoa_mission.files import make_folder, write_atomically
from ipoa_mission.flight.flight import Flight
from ipoa_mission.flight.summary import as_text, rounded
from ipoa_mission.forecast.energy import budget_of
from ipoa_mission.forecast.forecast import Forecast
from ipoa_mission.mission.about_file import digest
from ipoa_mission.mission.parameter_file import beside, write_with_parameters
from ipoa_mission.mission.plan_file import plan_text
from ipoa_mission.mission.waypoints_file import waypoints_text


def write_parts(whole: Flight, parts: Sequence[Forecast], summary: dict[str, Any], folder: Path) -> tuple[Path, ...]:
    """Write the parts of a flight as missions of their own; the whole, which no battery flies, is not written.

    `summary` is theirs, for NAME.json.

    Raises:
        BadInput: the folder cannot be made or written.
    """
    make_folder(folder)
    written, digests = list[Path](), dict[str, str]()
    for plan, part in zip(names_of(whole, parts, folder), parts, strict=True):
        texts = {plan: plan_text(part.mission), plan.with_suffix(".waypoints"): waypoints_text(part.mission)}
        write_with_parameters(part.mission, texts)
        written += [*texts, *([beside(plan)] if part.mission.parameters else [])]
        digests |= {path.name: digest(text) for path, text in texts.items()}
    about = folder / f"{whole.name}.json"
    write_atomically(about, as_text(summary | {"sha256": digests}))
    return (*written, about)


def names_of(whole: Flight, parts: Sequence[Forecast], folder: Path) -> list[Path]:
    """NAME-1.plan and so on."""
    return [folder / f"{whole.name}-{number}.plan" for number in range(1, len(parts) + 1)]


def parts_summary(whole: Flight, parts: Sequence[Forecast]) -> dict[str, Any]:
    """What NAME.json holds: the summary of the whole, and of each part its file, its time and its energy."""
    flights = []
    for path, part in zip(names_of(whole, parts, Path()), parts, strict=True):
        budget = budget_of(part)
        assert budget is not None, "it was split by its energy"
        taken = budget.used.between
        left = budget.left(taken)
        flights.append({
            "file": path.name,
            "items": len(part.mission.items),
            "time_s": rounded(part.estimate.total_s),
            "energy_wh": [rounded(wh) for wh in taken],
            "left": None if left is None else [rounded(share) for share in left],
        })  # fmt: skip
    return whole.summary() | {"flights": flights}
