"""A stranger's pages are never kept, linked or drawn: this program knows its own by their digest."""

import os
from types import SimpleNamespace

import pytest

import pilegrasp_ctrl.episode
from browser import program
from pilegrasp_ctrl import cli
from pilegrasp_ctrl.exceptions import ExportError
from pilegrasp_ctrl.files import cache_folder
from pilegrasp_ctrl.scenarios.paper.ledger import Example, page_origin, record_examples
from pilegrasp_ctrl.study.attempt import AttemptRow
from pilegrasp_ctrl.study.own_files import is_own, note_own
from pilegrasp_ctrl.viewer.pictures.chromium import NO_SANDBOX, Chromium
from synthetic_recording import synthetic
from synthetic_study import write_study

PLANTED = b"<!doctype html><script>document.title = 'planted'</script>"


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def blind(monkeypatch):
    """A machine without a browser."""
    monkeypatch.setattr("pilegrasp_ctrl.viewer.pictures.chromium.find_chromium", lambda: None)


def plant(file, content=PLANTED):
    """Write a file that is newer than everything."""
    file.write_bytes(content)
    os.utime(file, ns=(2**62, 2**62))


def test_a_file_is_own_as_it_was_noted_with_its_sources(tmp_path):
    page, source = tmp_path / "a.html", tmp_path / "a.npz"
    page.write_bytes(b"page")
    source.write_bytes(b"source")
    assert not is_own(page, source)
    note_own(page, source)
    assert is_own(page, source)
    assert not is_own(page)
    assert not is_own(page, source, "more")
    source.write_bytes(b"another")
    assert not is_own(page, source)
    source.write_bytes(b"source")
    plant(page, b"Page")
    assert not is_own(page, source)
    moved = (tmp_path / "there").absolute()
    moved.mkdir()
    (moved / "b.html").write_bytes(b"page")
    assert is_own(moved / "b.html", source)


def test_what_is_no_file_is_never_own(tmp_path):
    for what, make in (
        ("folder", lambda path: path.mkdir()),
        ("pipe", os.mkfifo),
        ("endless", lambda path: path.symlink_to("/dev/zero")),
    ):
        make(tmp_path / what)
        note_own(tmp_path / what)
        assert not is_own(tmp_path / what)


def test_without_a_writable_cache_everything_is_made_anew(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    note_own(tmp_path / "file")
    assert not is_own(tmp_path / "file")


def test_a_planted_page_that_is_newer_than_its_recording_is_made_anew(tmp_path, capsys, blind):
    folder = write_study(tmp_path / "study", recorded=(("aaaa", 0), ("aaaa", 5)))
    names = [folder / "recordings" / f"aaaa-{name}.html" for name in ("0", "5", "pair")]
    for name in names:
        plant(name)
    assert cli.main(["report", str(folder)]) == 0
    contents = [name.read_bytes() for name in names]
    assert all(b"planted" not in content and len(content) > 10_000 for content in contents)
    before = [name.stat().st_mtime_ns for name in names]
    assert cli.main(["report", str(folder)]) == 0
    assert [name.stat().st_mtime_ns for name in names] == before
    # The folder goes to another machine.
    (tmp_path / "cache").rename(tmp_path / "elsewhere")
    assert cli.main(["report", str(folder)]) == 0
    assert [name.read_bytes() for name in names] == contents
    assert [name.stat().st_mtime_ns for name in names] != before


def test_a_planted_page_is_not_written_through(tmp_path, capsys, blind):
    folder, victim = write_study(tmp_path / "study", recorded=(("aaaa", 0),)), tmp_path / "victim"
    victim.write_text("mine")
    (folder / "recordings" / "aaaa-0.html").symlink_to(victim)
    assert cli.main(["report", str(folder)]) == 0
    assert victim.read_text() == "mine"


def test_a_planted_thumbnail_is_drawn_anew_from_an_own_page(tmp_path, capsys, monkeypatch):
    folder = write_study(tmp_path / "study", recorded=(("aaaa", 0),))
    page, picture = (folder / "recordings" / f"aaaa-0{suffix}" for suffix in (".html", ".jpg"))
    plant(page)
    plant(picture, b"planted")
    drawn = []

    def thumbnails(pages, progress):
        drawn.extend(page.read_bytes() for page in pages)
        return [b"drawn"]

    monkeypatch.setattr("pilegrasp_ctrl.viewer.pictures.chromium.find_chromium", lambda: "chromium")
    monkeypatch.setattr("pilegrasp_ctrl.study.report.thumbnails", thumbnails)
    assert cli.main(["report", str(folder)]) == 0
    assert picture.read_bytes() == b"drawn"
    assert [b"planted" in content for content in drawn] == [False]


@pytest.mark.browser
@pytest.mark.slow
def test_a_planted_script_never_runs(tmp_path, capsys, monkeypatch):
    folder = write_study(tmp_path / "study", recorded=(("aaaa", 0),))
    page = folder / "recordings" / "aaaa-0.html"
    plant(page, PLANTED.replace(b"planted", b"ran"))
    opened = []
    load = Chromium.open

    def watched(self, file, *size):
        load(self, file, *size)
        opened.append(self.evaluate("document.title"))

    monkeypatch.setattr(Chromium, "open", watched)
    assert cli.main(["report", str(folder)]) == 0
    assert len(opened) == 1
    assert "ran" not in opened


# --- the paper's pages ------------------------------------------------------------------------------------------------


def test_the_paper_keeps_no_page_of_a_stranger(tmp_path, monkeypatch):
    row = AttemptRow("0123456789abcdef", 3, {}, {"success": True, "grasped": 1}, None)
    example = Example(row, "success")
    store = SimpleNamespace(folder=tmp_path, path=tmp_path / "study.db", scenario=lambda config_hash: None)
    asked = []

    def run(scenario, *, seed, record):
        asked.append(seed)
        return SimpleNamespace(success=True, grasped=1, recording=synthetic(frames=5, objects=2))

    monkeypatch.setattr(pilegrasp_ctrl.episode, "run", run)
    (tmp_path / "recordings").mkdir()
    plant(tmp_path / example.page)
    assert not is_own(tmp_path / example.page, page_origin(row))
    for _ in range(2):
        record_examples([example], store)
    assert asked == [3]
    assert b"planted" not in (tmp_path / example.page).read_bytes()
    assert is_own(tmp_path / example.page, page_origin(row))
    # An own page of another attempt is no page of this one.
    assert not is_own(tmp_path / example.page, page_origin(AttemptRow("0123456789abcdef", 4, {}, row.result, None)))
    assert len(list((cache_folder() / "pilegrasp" / "pages").iterdir())) == 1


# --- the browser's sandbox --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("user", "switched_off"), [(0, True), (1000, False)])
def test_the_sandbox_of_the_browser_is_off_for_root_alone(tmp_path, monkeypatch, user, switched_off):
    heard = tmp_path / "arguments"
    name = program(tmp_path, "chromium", f'#!/bin/sh\necho "$@" > {heard}\n')
    monkeypatch.setattr(os, "geteuid", lambda: user)
    with pytest.raises(ExportError, match="ended by itself"):
        Chromium(str(name))
    assert (NO_SANDBOX in heard.read_text().split()) is switched_off
