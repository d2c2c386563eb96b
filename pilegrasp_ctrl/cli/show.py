"""`pilegrasp show`."""

from __future__ import annotations

from .application import DebugOption, JsonOption, ScenarioArgument, SettingsOption, app, print_json


@app.command("show", epilog="The output is a scenario file: pilegrasp show spheres_wall > mine.toml")
def show_scenario(
    scenario: ScenarioArgument,
    settings: SettingsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Print a scenario with every key, those that its file leaves at their defaults included."""
    from ..config import load_scenario, parse_overrides
    from ..files import toml_text

    chosen = load_scenario(scenario, parse_overrides(settings or []))
    if as_json:
        print_json(chosen.model_dump(mode="json") | {"config_hash": chosen.config_hash()})
    else:
        print(toml_text(chosen.model_dump(mode="json")), end="")
