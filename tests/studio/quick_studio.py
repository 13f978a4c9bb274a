"""`ipoa-mission` whose studio plans quickly and waits less."""

from collections.abc import Callable

from ipoa_mission.__main__ import main
from tests.quick_search import put


def hasten(patch: Callable[[str, object], None] = put) -> None:
    for name, value in (("PLANNER", "tests.studio.quick_planner"), ("SETTLE_TIME_S", 0.2), ("FILE_CHECK_S", 0.2)):
        patch(f"ipoa_mission.studio.session.{name}", value)


if __name__ == "__main__":
    hasten()
    main()
