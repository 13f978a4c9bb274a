import re
from pathlib import Path

from tools import REPOSITORY
from tools.census import comments

REFERENCE = re.compile(r"[A-Za-z_]\w*(?:[./][A-Za-z_]\w*)*(?:\(\))?")
PROSE = re.compile(r'"""(?s:.*?)"""|(?:^|  ) *#.*', re.MULTILINE)
#: Of other projects, files and data.
FOREIGN = {
    "BLDG_HEIGHT", "MAVLink_command_long_message", "SOH", "_INT", "opfunu", "pyproject.toml", "rc.mc_defaults",
    "scipy.interpolate.CubicSpline", "shape_pos_vel_accel",
}  # fmt: skip


def known() -> set[str]:
    names = set[str]()
    for folder in ("ipoa_mission", "tools"):
        for path in (REPOSITORY / folder).rglob("*.py"):
            names |= {path.stem, *path.relative_to(REPOSITORY).parts}
            names.update(re.findall(r"\w+", PROSE.sub(" ", path.read_text(encoding="utf-8"))))
    return names | {path.name for path in Path(REPOSITORY).iterdir()}


def test_names_in_backticks_exist() -> None:
    names = known()
    stale = {
        f"{place}: {reference}"
        for place, text in comments()
        for reference in re.findall(r"`([^`\n]+)`", text)
        if REFERENCE.fullmatch(reference) and reference not in FOREIGN
        if not names.issuperset(re.split(r"[./]", reference.removesuffix("()")))
    }
    assert not stale
