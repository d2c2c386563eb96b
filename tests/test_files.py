"""Files: errors of reading, and files that are written whole or not at all."""

import os
import stat
import tomllib
from pathlib import Path

import pytest

from pilegrasp_ctrl.exceptions import ConfigurationError, ExportError, ModelError
from pilegrasp_ctrl.files import check_file, locked, parse_toml, read_file, read_toml, whole_file, write_whole


def test_a_file_is_replaced_only_when_it_is_complete(tmp_path):
    file = tmp_path / "result.txt"
    write_whole(file, b"old")
    with pytest.raises(KeyboardInterrupt), whole_file(file) as beside:  # noqa: PT012
        beside.write_bytes(b"ne")
        raise KeyboardInterrupt
    assert file.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [file]
    write_whole(file, b"new", durable=True)
    assert file.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [file]


def test_a_table_is_read_with_or_without_a_byte_order_mark(tmp_path):
    file = tmp_path / "table.toml"
    for mark in ("", "\ufeff"):
        file.write_text(f"{mark}key = 1\n", encoding="utf-8")
        assert read_toml(file) == {"key": 1}


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"key = ", "is not valid TOML"), (b"\xff", "is not valid TOML"), (b"a = " + b"[" * 5000, "is not valid TOML")],
)
def test_the_error_of_invalid_toml_names_the_file(tmp_path, content, words):
    file = tmp_path / "table.toml"
    file.write_bytes(content)
    with pytest.raises(ConfigurationError, match=f"table.toml: {words}"):
        read_toml(file)


def test_the_error_names_a_missing_file_and_its_content(tmp_path):
    with pytest.raises(ModelError, match=r"gone\.toml: no such file of gains$"):
        read_toml(tmp_path / "gone.toml", "of gains", ModelError)
    with pytest.raises(ConfigurationError, match="cannot be read"):
        read_toml(tmp_path)


# --- files that do not end --------------------------------------------------------------------------------------------


@pytest.fixture
def pipe(tmp_path):
    path = tmp_path / "pipe.toml"
    os.mkfifo(path)
    return path


@pytest.mark.parametrize("place", ["/dev/zero", "/dev/null", "pipe.toml"])
def test_only_a_regular_file_is_read(tmp_path, pipe, place):
    for read in (read_file, check_file):
        with pytest.raises(ModelError, match=r"is not a regular file; give one$"):
            read(tmp_path / place, 100, "of gains", ModelError)


def test_a_file_is_read_up_to_a_size(tmp_path):
    file = tmp_path / "table.toml"
    file.write_bytes(1024 * b"#")
    assert len(read_file(file, 1024)) == 1024
    check_file(file, 1024)
    file.write_bytes(1025 * b"#")
    for read in (read_file, check_file):
        with pytest.raises(ConfigurationError, match=r"too large for a file of gains; at most 1 KiB are read$"):
            read(file, 1024, "of gains")


def test_a_file_that_is_longer_than_its_size_says_is_read_up_to_that_size(tmp_path):
    # Files of the kernel have the size 0.
    with pytest.raises(ConfigurationError, match="too large"):
        read_file(Path("/proc/kallsyms"), 1024)


@pytest.mark.parametrize("name", ["a\0b", 5000 * "a", "file/inside"])
def test_a_name_that_no_file_can_have_is_named(tmp_path, name):
    (tmp_path / "file").touch()
    for read in (read_file, check_file):
        with pytest.raises(ConfigurationError, match="cannot be read: "):
            read(tmp_path / name, 100)


@pytest.mark.parametrize("head", ["a.", "[a.", 'x = {"a".', "x = {'a' . "])
def test_a_key_without_end_is_refused_at_once(head):
    with pytest.raises(ValueError, match="more than 32 parts"):
        parse_toml(head + head.lstrip("[x= {") * 100_000 + "b = 1")


@pytest.mark.parametrize(
    "text",
    ["a.b.c = 1", "[a.b]\nc = 1", 'a = """\n' + 50 * "." + '"""', "a = '" + 50 * "a." + "'", f"a = [{50 * '1.5,'}]"],
)
def test_usual_keys_and_dots_in_values_are_read(text):
    assert parse_toml(text) == tomllib.loads(text)


# --- a folder and a name that somebody else has prepared --------------------------------------------------------------


def test_a_lock_in_a_received_folder_changes_nothing_else(tmp_path, pipe):
    (tmp_path / "notes").write_text("mine")
    (tmp_path / ".lock").symlink_to("notes")
    with locked(tmp_path, "study"):
        pass
    assert (tmp_path / "notes").read_text() == "mine"
    (tmp_path / ".lock").unlink()
    (tmp_path / ".lock").symlink_to(pipe)
    with pytest.raises(ExportError, match=r"\.lock: is not a regular file"), locked(tmp_path, "study"):
        pass


def test_the_incomplete_file_has_another_name_each_time_and_the_usual_permissions(tmp_path):
    names = set()
    for _ in range(3):
        with whole_file(tmp_path / "a.html") as beside:
            names.add(beside.name)
            assert stat.S_IMODE(beside.stat().st_mode) == 0o666 & ~umask()
    assert len(names) == 3


def umask():
    """Return the bits of permission that new files lack."""
    bits = os.umask(0)
    os.umask(bits)
    return bits


def test_a_link_is_replaced_and_not_followed(tmp_path):
    (tmp_path / "notes").write_text("mine")
    (tmp_path / "a.html").symlink_to("notes")
    write_whole(tmp_path / "a.html", b"page")
    assert (tmp_path / "notes").read_text() == "mine"
    assert (tmp_path / "a.html").read_bytes() == b"page"
