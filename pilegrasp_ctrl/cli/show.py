"""`pilegrasp show`."""

from __future__ import annotations

from typing import Annotated

import typer

from .application import DebugOption, JsonOption, ScenarioArgument, SettingsOption, app, print_json, with_examples


def _print_schema(wanted: bool) -> None:
    if wanted:
        from .schema import schema_text

        print(schema_text(), end="")
        raise typer.Exit()


@app.command(
    "show",
    epilog=with_examples(
        "The output is a scenario file. With `#:schema ./scenario.schema.json` in its first line, editors that use "
        "taplo complete and check its keys.",
        "pilegrasp show spheres_wall > mine.toml",
        "pilegrasp show --schema > scenario.schema.json",
    ),
)
def show_scenario(
    scenario: ScenarioArgument,
    settings: SettingsOption = None,
    schema: Annotated[
        bool,
        typer.Option(
            "--schema",
            metavar="",
            is_eager=True,
            callback=_print_schema,
            help="Print the JSON schema of scenario files instead, for editors; no scenario is needed.",
        ),
    ] = False,
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
