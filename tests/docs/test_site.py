import re
from pathlib import Path

import pytest

from tools.generate import reference

REPOSITORY = Path(__file__).parents[2]
LOADED = re.compile(
    r"<(?:script|img|iframe)[^>]*\bsrc=[\"']?(https?:)?//|<link(?![^>]*canonical)[^>]*href=[\"']?https?:"
)


def test_the_page_of_names_has_them_all() -> None:
    assert reference.PAGE.read_text(encoding="utf-8") == reference.page(), "run python -m tools.generate.reference"


def test_the_site_builds_without_a_warning_and_loads_no_foreign_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("material")
    build = pytest.importorskip("mkdocs.commands.build").build
    from mkdocs.config import load_config

    monkeypatch.setenv("NO_MKDOCS_2_WARNING", "1")
    monkeypatch.chdir(REPOSITORY)
    build(load_config(".mkdocs.yml", strict=True, site_dir=str(tmp_path)))
    pages = {path.relative_to(tmp_path).as_posix(): path.read_text() for path in tmp_path.rglob("*.html")}
    for page in (REPOSITORY / "docs").rglob("*.md"):
        name = page.relative_to(REPOSITORY / "docs").with_suffix(".html").as_posix()
        assert name.replace("README", "index") in pages
    assert not {name for name, text in pages.items() if LOADED.search(text)}
    style = "".join(path.read_text() for path in tmp_path.rglob("*.css"))
    assert "fonts.g" not in style
    assert "Predict when each item of the mission will be done" in pages["reference.html"]
    assert "glossary.html" in (tmp_path / "search" / "search_index.json").read_text()
