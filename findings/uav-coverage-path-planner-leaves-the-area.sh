#!/bin/sh
# uav-coverage-path-planner flies 700 of 3573 m outside of its area, and to the east for a heading of 0.
#
# uav-coverage-path-planner 1.0.0, optimize_coverage_route of "a polygonal operating area". Guess: in an area of 300 by
# 300 m with a notch 100 m wide from the north, as round a tower, the lanes go round the notch, or a constraint is
# violated. Seen: with lanes along heading 0 seven of eleven cross it, and constraints_satisfied is True. Heading 0 is
# to the east, 90 to the north, counterclockwise, unlike a course. Exits 1 if that changes.
set -e
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q uav-coverage-path-planner==1.0.0 shapely==2.1.2
cd "$folder"
./venv/bin/python - <<'PY'
import math
from importlib.metadata import version

from shapely import LineString, Polygon
from uav_coverage_path_planner import OptimizationConfig, PlanningProblem, QualityConstraints, optimize_coverage_route


def plan(area, heading):
    quality = QualityConstraints(heading_min_deg=heading, heading_max_deg=heading + 0.001)
    optimizer = OptimizationConfig(population_size=10, max_generations=5, restarts=1, seed=1)
    problem = PlanningProblem(area, (50, 50), 60, quality=quality, optimizer=optimizer)
    return optimize_coverage_route(problem)


def course(area, heading):
    (west, south), (east, north) = plan(area, heading).route[1:3]
    return round(math.degrees(math.atan2(east - west, north - south))) % 180


notched = (0, 0), (300, 0), (300, 300), (200, 300), (200, 100), (100, 100), (100, 300), (0, 300)
found = plan(notched, 0)
flown = LineString(found.route[1:-1])
outside = round(flown.difference(Polygon(notched).buffer(0.001)).length)
courses = [course(((0, 0), (100, 0), (100, 400), (0, 400)), heading) for heading in (0, 30, 90)]
satisfied = found.optimized.constraints_satisfied
name = "uav-coverage-path-planner"
print(f"{name} {version(name)}: {outside} of {round(flown.length)} m outside,")
print(f"constraints satisfied: {satisfied}; courses of lanes with headings 0, 30 and 90: {courses}")
raise SystemExit(0 if outside == 700 and satisfied and courses == [90, 60, 0] else 1)
PY
