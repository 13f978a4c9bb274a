"""Plan surveys: parallel lines over an area, split into checked flights.

Read `survey_flight.plan_survey` first. `survey_plan` gives obstacles more room until every flight keeps its clearance.
For each try `survey_task` lays lines (`cover`), `survey_plan` splits them (`tour`), and `assembly` writes missions.
`flown_coverage` and `resume` measure flights.
"""
