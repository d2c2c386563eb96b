"""The paper's figures and tables, one file each: what is run for it and how it is drawn."""

from importlib import import_module
from pathlib import Path

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment

NAMES = ("fig06", "fig07", "fig08", "fig09", "fig10", "fig11", "velocity_force", "motion_pattern", "table1")

EXPLANATIONS = Path(__file__).with_name("explanations.toml")
"""What experiments say about claims that differ from the paper."""


def experiment(name: str) -> Experiment:
    """Return an experiment by name.

    Raises:
        ConfigurationError: where there is none of that name.
    """
    if name not in NAMES:
        raise ConfigurationError(f"there is no experiment {name!r}; choose from {', '.join(NAMES)} or all")
    found = import_module(f"{__name__}.{name}").EXPERIMENT
    assert isinstance(found, Experiment)
    return found
