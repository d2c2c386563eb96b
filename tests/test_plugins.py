"""Functions of a user come from installed packages and from folders that the command names, and from nowhere else."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import places
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.plugins import adopt, load_plugin, plugin_digest, plugin_folders, use_plugins

PARTS = ("parts",)


def write(folder, **modules):
    folder.mkdir(exist_ok=True, parents=True)
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(textwrap.dedent(text))
    return folder


def load(name):
    return load_plugin(name, "program", PARTS, named=True).function


def refusal(name):
    with pytest.raises(ConfigurationError) as caught:
        load(name)
    return str(caught.value)


def test_a_function_of_a_named_folder_is_found_with_what_lies_beside_it(tmp_path):
    write(tmp_path, wiggle="import step\n\ndef plan(parts):\n    return step.SIZE + parts\n", step="SIZE = 3\n")
    assert use_plugins([tmp_path]) == plugin_folders() == (str(tmp_path),)
    assert load("wiggle:plan")(2) == 5
    assert not list(tmp_path.rglob("__pycache__"))


def test_a_function_of_an_installed_package_is_found():
    # It was found, because its parameter is known.
    assert "takes (version); its parameters must be called (parts)" in refusal("packaging.version:parse")
    assert load_plugin("pilegrasp_ctrl.analysis.motion:measure_attempt", "measure", ("recording",)).function


def test_nothing_comes_from_the_current_folder_or_pythonpath_or_the_standard_library(tmp_path):
    hostile = write(
        tmp_path / "received",
        evil="from pathlib import Path\nPath('ran').touch()\n\ndef plan(parts):\n    pass\n",
    )
    script = """
        from pilegrasp_ctrl.exceptions import ConfigurationError
        from pilegrasp_ctrl.plugins import load_plugin
        for name in ("evil:plan", "os:abort", "code:interact", "shutil:rmtree", "__main__:plan"):
            try:
                load_plugin(name, "program", ("parts",), named=True)
            except ConfigurationError as error:
                print(error)
    """
    environment = {"PYTHONPATH": f"{places.ROOT}:.:{hostile}", "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    command = [sys.executable, "-c", textwrap.dedent(script)]
    found = subprocess.run(command, cwd=hostile, env=environment, capture_output=True, text=True, check=True)
    sentences = found.stdout.splitlines()
    assert len(sentences) == 5, found.stdout
    assert sentences[0] == (
        "program = 'evil:plan': no module 'evil' is in the installed packages; name its folder by --plugins DIR"
    )
    assert all("no module" in sentence for sentence in sentences[:4])
    assert "is not of the form module:function" in sentences[4]
    assert not (hostile / "ran").exists()


def test_a_plugin_imports_installed_packages_wherever_they_lie(tmp_path):
    write(tmp_path, wiggle="import numpy, pinocchio, mujoco\n\ndef plan(parts):\n    pass\n")
    script = f"""
        from pilegrasp_ctrl.plugins import load_plugin, use_plugins
        use_plugins([{str(tmp_path)!r}])
        load_plugin("wiggle:plan", "program", ("parts",))
    """
    environment = {"PYTHONPATH": str(places.ROOT), "PATH": "/usr/bin:/bin"}
    subprocess.run([sys.executable, "-c", textwrap.dedent(script)], env=environment, check=True)


def test_the_imports_of_a_plugin_do_not_come_from_the_current_folder(tmp_path, monkeypatch):
    mine = write(tmp_path / "mine", wiggle="import helper_of_mine\n\ndef plan(parts):\n    pass\n")
    here = write(tmp_path / "here", helper_of_mine="raise SystemExit('ran')\n")
    monkeypatch.chdir(here)
    monkeypatch.setattr(sys, "path", ["", str(here), *sys.path])
    use_plugins([mine])
    assert "ModuleNotFoundError: No module named 'helper_of_mine' (wiggle.py, line 1)" in refusal("wiggle:plan")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("nowhere:plan", "no module 'nowhere' is in {folder} or the installed packages; name its folder by --plugins"),
        ("good.inner:plan", "'good' has no module 'good.inner'; see its folder"),
        ("good:pla", "the module 'good' has no function 'pla'; did you mean 'plan'?"),
        ("good:SIZE", "the module 'good' has no function 'SIZE'; define `def SIZE(...)` in it"),
        ("good:other", "takes (hand); its parameters must be called (parts)"),
        ("good:two", "takes (parts, more), but it is called with (parts); let it take these"),
        ("broken:plan", "the module cannot be imported: SyntaxError: invalid syntax (broken.py, line 1)"),
        ("raises:plan", "the module cannot be imported: ZeroDivisionError: division by zero (raises.py, line 2)"),
        ("leaves:plan", "the module cannot be imported: SystemExit: 3 (leaves.py, line 1)"),
        ("lacks:plan", "the module cannot be imported: ModuleNotFoundError: No module named 'gone' (lacks.py, line 1)"),
        ("good:plan:x", "is not of the form module:function"),
        ("../good:plan", "is not of the form module:function"),
        (":plan", "is not of the form module:function"),
        ("good:", "is not of the form module:function"),
    ],
)
def test_each_failure_is_one_sentence_that_names_the_function(tmp_path, name, sentence):
    write(
        tmp_path,
        good="SIZE = 1\n" + "".join(f"def {it}: pass\n" for it in ("plan(parts)", "other(hand)", "two(parts, more)")),
        broken="def plan(:\n",
        raises="\nSIZE = 1 / 0\n",
        leaves="raise SystemExit(3)\n",
        lacks="import gone\n",
    )
    use_plugins([tmp_path])
    text = refusal(name)
    assert text.startswith(f"program = {name!r}")
    assert sentence.format(folder=tmp_path) in text
    assert "\n" not in text


def test_what_is_no_folder_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match=r"--plugins '.*missing': is no folder"):
        use_plugins([tmp_path / "missing"])


def test_the_digest_follows_the_module_and_what_it_imports(tmp_path):
    def digest():
        use_plugins([tmp_path])
        return plugin_digest("wiggle:plan", "program", PARTS)

    write(
        tmp_path, wiggle="import step\n\ndef plan(parts):\n    return step.SIZE\n", step="SIZE = 3\n", other="A = 1\n"
    )
    first = digest()
    write(tmp_path, other="A = 22\n")
    assert digest() == first
    write(tmp_path, step="SIZE = 14\n")
    assert digest() != first
    assert load("wiggle:plan")(0) == 14
    write(tmp_path, step="SIZE = 3\n")
    assert digest() == first


def test_modules_of_folders_that_are_no_longer_named_are_forgotten(tmp_path):
    for number in (1, 2):
        folder = write(tmp_path / str(number), wiggle=f"def plan(parts):\n    return {number}\n")
        use_plugins([folder])
        assert load("wiggle:plan")(0) == number
    use_plugins([])
    assert "no module 'wiggle'" in refusal("wiggle:plan")
    assert str(tmp_path / "2") not in sys.path


def test_a_module_that_python_has_loaded_from_elsewhere_is_not_taken_for_a_users(tmp_path):
    use_plugins([write(tmp_path, places="def plan(parts):\n    pass\n")])
    assert f"another module 'places' is already loaded from {places.__file__}; rename yours" in refusal("places:plan")


def straight(parts):
    return parts


def test_a_function_of_this_process_counts_with_its_file():
    name = adopt(straight, "plan", PARTS, named=True)
    assert name.endswith("test_plugins:straight")
    assert load(name) is straight
    assert str(Path(__file__)) in load_plugin(name, "program", PARTS).sources.stamps


def test_a_function_without_a_file_counts_with_its_code():
    digests = set()
    for size in (1, 2):
        space = {"__name__": "notebook"}
        exec(f"def plan(parts):\n    return {size}\n", space)
        digests.add(plugin_digest(adopt(space["plan"], "plan", PARTS), "program", PARTS))
    assert len(digests) == 2


def test_values_that_a_digest_would_not_cover_are_refused():
    size = 3

    def plan(parts):
        return size

    with pytest.raises(ConfigurationError, match="uses size of the function around it"):
        adopt(plan, "plan", PARTS)
    with pytest.raises(ConfigurationError, match="must be a function that `def` made"):
        adopt(print, "plan", PARTS)
