"""Robots are found by name, and a missing package is named."""

from importlib.metadata import PackageNotFoundError

import pytest

from pilegrasp_ctrl import robots
from pilegrasp_ctrl.exceptions import ModelError


def test_the_panda_is_found_in_example_robot_data():
    assert robots.panda_urdf().is_file()


def test_without_example_robot_data_the_error_names_the_package(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(robots, "distribution", missing)
    with pytest.raises(ModelError, match="pip install example-robot-data"):
        robots.panda_urdf()


def test_the_error_of_a_package_without_the_panda_asks_for_a_newer_one(monkeypatch):
    class Empty:
        files = None

    monkeypatch.setattr(robots, "distribution", lambda name: Empty())
    with pytest.raises(ModelError, match=r"has no file urdf/panda\.urdf; install a newer one"):
        robots.panda_urdf()
