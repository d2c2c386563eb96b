"""`pilegrasp doctor`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from ..exceptions import PilegraspError
from .application import DebugOption, JsonOption, app, make_console, print_json, with_examples
from .progress import make_progress

if TYPE_CHECKING:
    from ..validation.installation import Check
    from ..validation.physics.physics_check import PhysicsCheck


@app.command("doctor", epilog=with_examples("", "pilegrasp doctor", "pilegrasp doctor --physics"))
def doctor(
    physics: Annotated[
        bool,
        typer.Option("--physics", metavar="", help="Compare the simulation with formulas and published numbers."),
    ] = False,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Check this installation: packages, solvers, engines, browser, and one short run."""
    if physics:
        measured = _measure()
        failed = [check.name for check in measured if not (check.ok or check.known)]
        _report(failed, measured, _physics_table(measured), as_json)
        return
    from ..validation.installation import examine

    checks = examine()
    _report([check.name for check in checks if check.required and not check.ok], checks, _table(checks), as_json)


def _measure() -> list[PhysicsCheck]:
    """Run the checks of the physics and show how far they are."""
    from ..validation.physics.suite import physics_checks

    columns = (BarColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    with make_progress(*columns) as bar:
        line = bar.add_task("", total=1.0)
        return physics_checks(lambda share, name: bar.update(line, completed=share, description=escape(name)))


def _report(failed: list[str], checks: Sequence[Check | PhysicsCheck], table: Table, as_json: bool) -> None:
    if as_json:
        print_json({"ok": not failed, "checks": [check.as_dict() for check in checks]})
    else:
        make_console().print(table)
        if not failed:
            print("Everything that is needed works.")
    if failed:
        raise PilegraspError(f"these checks failed: {', '.join(failed)}")


def _table(checks: Sequence[Check]) -> Table:
    table = Table(box=None, pad_edge=False)
    for column in ("check", "", "detail"):
        table.add_column(column)
    for check in checks:
        verdict = "[green]ok" if check.ok else "[red]failed" if check.required else "[yellow]absent"
        table.add_row(escape(check.name), verdict, escape(check.detail))
    return table


def _physics_table(checks: Sequence[PhysicsCheck]) -> Table:
    from ..validation.physics.physics_check import HEADER, cells

    table = Table(box=None, pad_edge=False)
    for number, column in enumerate(HEADER):
        table.add_column(column, justify="right" if 1 <= number <= 3 else "left")
    for check in checks:
        *texts, verdict = cells(check)
        table.add_row(*map(escape, texts), f"[{'green' if check.ok else 'yellow' if check.known else 'red'}]{verdict}")
    return table
