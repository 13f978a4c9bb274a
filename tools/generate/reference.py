"""Write docs/reference.md: every public name, for mkdocstrings to fill from its docstring.

python -m tools.generate.reference
"""

import ipoa_mission
from tools import REPOSITORY, command_line

PAGE = REPOSITORY / "docs" / "reference.md"
HEAD = """\
# Python, name by name

The names of `import ipoa_mission`; [api.md](api.md) shows it at work. The site puts the docstring of each name here. In
a checkout, where a line has only module and name, use `help(ipoa_mission.NAME)`.

"""


def page() -> str:
    public = ((name, getattr(ipoa_mission, name)) for name in ipoa_mission.__all__)
    return HEAD + "\n".join(f"::: {item.__module__}.{name}" for name, item in public) + "\n"


if __name__ == "__main__":
    command_line(__doc__).parse_args()
    PAGE.write_text(page(), encoding="utf-8")
