"""`reproduce`: the paper's tables and figures, measured again."""

from pathlib import Path
from typing import Annotated

import typer

from ipoa_mission.cli.interrupting import left_behind
from ipoa_mission.cli.options import JsonOption
from ipoa_mission.cli.output import progress_bar, tell, tell_json
from ipoa_mission.files import make_folder


def reproduce(
    what: Annotated[str, typer.Argument(metavar="WHAT", help="table-3, figure-7, ablation, ..., or all.")],
    runs: Annotated[
        int | None, typer.Option("--runs", metavar="N", min=1, help="Runs of each; left out, as many as the paper.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Where runs, tables and figures are kept.")] = Path(
        "reproduction"
    ),
    jobs: Annotated[int, typer.Option("--jobs", metavar="N", min=1, help="Processes.")] = 2,
    executor: Annotated[
        str | None, typer.Option("--executor", metavar="URL", help="A Dask scheduler, as tcp://HOST:PORT.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Measure a table or figure of the paper again and write it; runs that are there are not repeated.

    Example: `ipoa-mission reproduce table-3 --runs 3`
    """
    from ipoa_mission.paper.reproduce import reproduce as measure

    make_folder(out)
    kept = f"the runs made so far are kept in {out}; the same command goes on from there"
    with left_behind(kept), progress_bar("measuring") as show:
        files = measure(what, runs, out, jobs, executor, show)
    if as_json:
        tell_json({"written": [str(file) for file in files]})
    else:
        tell(*(f"written: {file}" for file in files))
