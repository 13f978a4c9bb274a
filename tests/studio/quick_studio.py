"""`ipoa-mission` whose studio plans quickly and waits less."""

from collections.abc import Callable

from ipoa_mission.__main__ import main
from tests.quick_search import put


def hasten(patch: Callable[[str, object], None] = put) -> None:
    places = {
        "session.PLANNER": "tests.studio.quick_planner",
        "session.SETTLE_TIME_S": 0.2,
        "sessions.FILE_CHECK_S": 0.2,
    }
    for name, value in places.items():
        patch(f"ipoa_mission.studio.{name}", value)


if __name__ == "__main__":
    hasten()
    main()
