"""Compare our planner with OMPL's and mealpy's by a reference optimum (docs/lab/planning.md).

    taskset -c 0 python -m tools.benchmarks.planning --mealpy PYTHON     everything; takes half an hour of CPU
    taskset -c 0 python -m tools.benchmarks.planning --quick --rows rows.csv
    taskset -c 0 python -m tools.benchmarks.planning --parts planner     this measured again, the other rows stay
    python -m tools.benchmarks.planning --parts                          tables and pictures from the rows, no more

Rows are in docs/planning/rows.csv. The tables of docs/lab/planning.md and the pictures next to the rows are made from
them alone (with other `--rows`, tables are printed). Needs: pip install ompl cma; mealpy needs an interpreter of its
own, because it requires an older NumPy. Times are CPU seconds unless marked as wall.
"""

import os
from pathlib import Path

from ipoa_mission.files import read_text, write_atomically
from ipoa_mission.report.plots import write_picture
from tools import REPOSITORY, command_line
from tools.benchmarks.planning_benchmark.maps import MAPS
from tools.benchmarks.planning_benchmark.measure import PARTS, Work
from tools.benchmarks.planning_benchmark.rows import add_row, read_rows
from tools.benchmarks.planning_benchmark.tell import pictures, tables

DOCUMENT = REPOSITORY / "docs" / "lab" / "planning.md"
ROWS = DOCUMENT.parent / "planning" / "rows.csv"
QUICK = ("spheres-8-1", "cylinders-8-1", "block-60-1")


def main() -> None:
    parser = command_line(__doc__)
    parser.add_argument("--parts", nargs="*", choices=PARTS, default=list(PARTS))
    parser.add_argument("--maps", nargs="+", default=[], help="of planning_benchmark/maps.py, or other seeds of them")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--starts", type=int, default=12, help="searches of the reference")
    parser.add_argument("--mealpy", default="", metavar="PYTHON", help="an interpreter that has mealpy")
    parser.add_argument("--quick", action="store_true", help="three maps, one seed, a weaker reference")
    parser.add_argument("--rows", type=Path, default=ROWS)
    wanted = parser.parse_args()
    if wanted.parts and len(os.sched_getaffinity(0)) != 1:
        parser.error("expected to be measured on one core: begin with `taskset -c 0`")
    work = Work(
        maps=tuple(wanted.maps) or (QUICK if wanted.quick else MAPS),
        seeds=1 if wanted.quick else wanted.seeds,
        starts=4 if wanted.quick else wanted.starts,
        mealpy=wanted.mealpy,
    )
    for part in wanted.parts:
        for row in PARTS[part](work):
            add_row(wanted.rows, row)
            print(row.part, row.map, row.method, row.setting, row.cost, f"{row.cpu_s:.2f} s", flush=True)
    told = tables(read_rows(wanted.rows))
    if wanted.rows != ROWS:
        print(*(f"\n{title}\n\n{table}" for title, table in told.items()), sep="\n")
        return
    text = read_text(DOCUMENT)
    for title, table in told.items():
        mark = f"<!-- {title} -->\n"
        before, found, after = text.partition(mark)
        if found:
            text = f"{before}{mark}{table}\n{after[after.index('<!-- end -->') :]}"
    write_atomically(DOCUMENT, text)
    for name, picture in pictures(read_rows(wanted.rows)).items():
        write_picture(picture, ROWS.with_name(f"{name}.svg"))


if __name__ == "__main__":
    main()
