from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from ipoa_mission.cli.interrupting import ChangesMade, interruptible
from ipoa_mission.files import make_folder
from ipoa_mission.options import JsonOption, argument, flag
from ipoa_mission.terminal import print_json, print_lines, progress_bar


@dataclass
class RunOptions:
    runs: Annotated[int | None, flag("--runs", "Runs of each; default: as in the paper.", "N", min=1)] = None
    out: Annotated[Path, flag("--out", "Folder of runs, tables and figures.", "DIR")] = Path("reproduction")
    jobs: Annotated[int, flag("--jobs", "Processes.", "N", min=1)] = 2


@interruptible
def reproduce(
    changes: ChangesMade,
    what: Annotated[str, argument("WHAT", "table-3, figure-7, dimension, ..., or all.")],
    how: RunOptions,
    as_json: JsonOption = False,
) -> None:
    """Measure a table or figure of the paper again and write it; existing runs are reused.

    Example: `ipoa-mission reproduce table-3 --runs 3`
    """
    from ipoa_mission.paper.reproduce import open_processes
    from ipoa_mission.paper.reproduce import reproduce as measure

    make_folder(how.out)
    kept = f"finished runs are in {how.out}; the same command continues from there"
    with changes.reporting(kept), progress_bar("measuring") as show:
        files = measure(what, how.runs, how.out, open_processes(how.jobs), show)
    if as_json:
        print_json({"written": [str(file) for file in files]})
    else:
        print_lines(*(f"written: {file}" for file in files))
