"""The files of a planned mission."""

import json
from pathlib import Path

from ipoa_mission.cli.folders import make_folder
from ipoa_mission.cli.job import PlannedJob
from ipoa_mission.cli.summary import summarise
from ipoa_mission.files import write_atomically
from ipoa_mission.mission.plan_file import write_plan
from ipoa_mission.mission.waypoints_file import write_waypoints


def write_files(job: PlannedJob, folder: Path) -> list[Path]:
    """NAME.plan, NAME.waypoints and NAME.json in `folder`, which is made if it is not there.

    A `.waypoints` file holds neither fence nor rally points; the remarks of the job say so.
    """
    make_folder(folder)
    plan, waypoints, summary = (folder / f"{job.name}{suffix}" for suffix in (".plan", ".waypoints", ".json"))
    write_plan(job.mission, plan)
    write_waypoints(job.mission, waypoints)
    write_atomically(summary, json.dumps(summarise(job), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    return [plan, waypoints, summary]
