from pathlib import Path

import pytest

from ipoa_mission import BadInput
from ipoa_mission.studio import bundle, studio_verb
from tests.refused import refuses


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with refuses("bad-input", "none.toml", kind=BadInput):
        studio_verb.studio(studio_verb.PageOptions(), tmp_path / "none.toml")
    assert not list(tmp_path.iterdir())


def test_missing_files_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(studio_verb, "LIBRARIES", ("numpy", "no_such_library"))
    with refuses("package-missing", "", "no_such_library"):
        studio_verb.studio(studio_verb.PageOptions())


def test_studio_without_a_page_and_npm_names_a_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    web = tmp_path / "package" / "studio" / "web"
    web.mkdir(parents=True)
    (tmp_path / "package" / "report" / "assets").mkdir(parents=True)
    for shared in bundle.SHARED:
        (tmp_path / "package" / shared).write_text("")
    monkeypatch.setattr(bundle, "WEB", web)
    monkeypatch.setattr(bundle, "copies", lambda part: ())
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    with refuses("page-not-built") as caught:
        bundle.built_page(lambda words: None)
    assert "Node.js" in str(caught.value.hint)


def test_a_page_counts_by_the_sources_that_it_was_made_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    web, second = (tmp_path / place / "studio" / "web" for place in ("here", "there"))
    for folder in (web, second):
        (folder.parents[1] / "report" / "assets").mkdir(parents=True)
        for shared in bundle.SHARED:
            (folder.parents[1] / shared).write_text("")
        (folder / "dist").mkdir(parents=True)
        (folder / "main.tsx").write_text("1")
    (web / "dist" / bundle.DIGEST).write_text(bundle.sources_digest(web))
    monkeypatch.setattr(bundle, "WEB", web)
    assert bundle.built_page(lambda words: None) == web / "dist"
    (web / "main.tsx").write_text("2")  # as one who works on it
    assert not bundle.has_page(web)
    (second / "dist" / bundle.DIGEST).write_text(bundle.sources_digest(web))  # installed beside
    monkeypatch.setattr(bundle, "copies", lambda part: iter([second]))
    assert bundle.built_page(lambda words: None) == second / "dist"
