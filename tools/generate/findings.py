"""Write docs/findings.md: every finding of `check` by its code.

python -m tools.generate.findings
"""

from ipoa_mission.rules import RULES
from tools import REPOSITORY, command_line

PAGE = REPOSITORY / "docs" / "findings.md"
HEAD = """\
# Findings

Made from the code by `python -m tools.generate.findings`. `check` prints the code of a finding behind it;
`--json` has it too. A code keeps its meaning. A code marked "yes" can be left out, with
`check --ignore CODE` or in a scenario with `ignore = ["CODE"]` under `[safety]`; from the others a crash may follow.

| code | means | do | may be ignored |
|---|---|---|---|
"""


def page() -> str:
    rows = (f"| `{code}` | {rule.means} | {rule.do} | {'' if rule.crash else 'yes'} |" for code, rule in RULES.items())
    return HEAD + "\n".join(rows) + "\n"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
