"""Pages of the site that the code itself writes: the API, every key of a scenario, and the command line."""

from __future__ import annotations

import ast
import functools
import re
from typing import Any

import typer

from links import ROOT
from pilegrasp_ctrl.cli import app
from pilegrasp_ctrl.config import Scenario, dotted_keys
from scenario_table import key_row

API = {
    "Attempts and recordings": ("config", "episode", "plugins", "programs", "recording", "study", "viewer"),
    "Arms": ("arm",),
    "Tasks": ("tasks",),
    "Limits": ("limits",),
    "Controllers": ("control",),
    "Trajectories, primitives and plans": ("planning", "primitives", "trajectories"),
    "Simulated arms and their responses": ("plant",),
    "Values": ("types",),
    "Errors": ("exceptions",),
}
"""Pages of the API: their titles, and the rooms whose public names they hold."""


@functools.cache
def generated_pages() -> dict[str, str]:
    """Return the generated pages by the path that they would have in docs/."""
    pages = {f"reference/api/{_slug(title)}.md": api_page(title) for title in API}
    return {
        "reference/keys.md": keys_page(),
        "reference/command-line.md": command_line_page(),
        **pages,
    }


def api_page(title: str) -> str:
    """Return the page of some rooms; mkdocstrings fills in signatures and docstrings."""
    lines = [
        f"# {title}",
        "",
        "These names belong to the package itself: `import pilegrasp_ctrl as pg`, then `pg.NAME`.",
        "",
    ]
    for name, module in public_names(title).items():
        options = f'    options:\n      heading: "{name}"\n      toc_label: "{name}"'
        lines += [f"::: pilegrasp_ctrl.{module}.{name}", options, ""]
    return "\n".join(lines)


def public_names(title: str) -> dict[str, str]:
    """Return the public names on a page of the API, and their modules below the package."""
    tree = ast.parse((ROOT / "pilegrasp_ctrl" / "__init__.py").read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level == 1]
    found = {alias.name: node.module or "" for node in imports for alias in node.names}
    return {name: module for name, module in sorted(found.items()) if module.partition(".")[0] in API[title]}


def keys_page() -> str:
    """Return the page with a section for each key of a scenario."""
    schema = Scenario.model_json_schema()
    lines = [
        "# Every key of a scenario",
        "",
        "A scenario is a TOML file. `--set KEY=VALUE` changes a key for one attempt, and a file holds it in the table",
        "before the dot. `pilegrasp show NAME` prints the values of a shipped scenario.",
        "",
    ]
    table = None
    for key in dotted_keys():
        head = key.rpartition(".")[0]
        if head != table:
            lines += [f"## {f'[{head}]' if head else 'Before the first table'}", ""]
            table = head
        lines += [*_key_section(schema, key), ""]
    return "\n".join(lines)


def _key_section(schema: dict[str, Any], key: str) -> list[str]:
    name, meaning, unit, default, allowed = key_row(schema, key)
    facts = [f"default: {default}", f"allowed: {allowed}"]
    return [f"### {name}", "", f"{meaning[:1].upper()}{meaning[1:]}.", "", *(f"- {fact}" for fact in facts)] + (
        [] if unit == "-" else [f"- unit: {unit}"]
    )


def command_line_page() -> str:
    """Return the page with the help of every verb."""
    group = typer.main.get_command(app)
    lines = [
        "# Command line",
        "",
        "`pilegrasp VERB --help` prints what stands here. `python -m pilegrasp_ctrl` is the same command. The exit",
        "status is 0 if the command did what it was asked, 2 after an error, and 130 after an interrupt.",
        "",
    ]
    for name, command in group.commands.items():
        lines += [f"## pilegrasp {name}", "", _plain(command.help or ""), "", *_usage(name, command), ""]
        lines += [*_parameters(command), ""]
        if command.epilog:
            lines += [_plain(command.epilog), ""]
    return "\n".join(lines)


def _usage(name: str, command: Any) -> list[str]:
    arguments = [_metavar(each) for each in command.params if not _is_option(each)]
    return ["```text", " ".join(["pilegrasp", name, *arguments, "[OPTIONS]"]), "```"]


def _parameters(command: Any) -> list[str]:
    rows = ["| option | meaning | default |", "|---|---|---|"]
    for each in command.params:
        words = [*each.opts, *each.secondary_opts] if _is_option(each) else []
        if not words or not each.is_flag:
            words.append(_metavar(each))
        absent = each.required or each.default in (None, False, ())
        default = "" if absent else f"`{getattr(each.default, 'value', each.default)}`"
        cells = (f"`{' '.join(words)}`", _plain(getattr(each, "help", "") or ""), default)
        rows.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    return rows


def _is_option(parameter: Any) -> bool:
    return bool(parameter.param_type_name == "option")


def _metavar(parameter: Any) -> str:
    return str(parameter.metavar or parameter.name.upper())


def _plain(text: str) -> str:
    """Return a help text on one line for each paragraph."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in re.split(r"\n\s*\n", text)).strip()


def _slug(title: str) -> str:
    return re.sub(r"\W+", "-", title.lower())
