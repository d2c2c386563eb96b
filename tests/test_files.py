"""Files: errors of reading, and files that are written whole or not at all."""

import pytest

from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.files import read_toml, whole_file, write_whole


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
