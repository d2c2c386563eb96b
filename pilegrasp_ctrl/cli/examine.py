"""`pilegrasp doctor`."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from ..exceptions import PilegraspError
from .application import app
from .options import DebugOption, JsonOption, make_console, print_json


@app.command("doctor")
def doctor(as_json: JsonOption = False, debug: DebugOption = False) -> None:
    """Check this installation: packages, solvers, engines, browser, and one short run."""
    from ..doctor import examine

    checks = examine()
    failed = [check.name for check in checks if check.required and not check.ok]
    if as_json:
        print_json({"ok": not failed, "checks": [check.as_dict() for check in checks]})
    else:
        table = Table(box=None, pad_edge=False)
        for column in ("check", "", "detail"):
            table.add_column(column)
        for check in checks:
            verdict = "[green]ok" if check.ok else "[red]failed" if check.required else "[yellow]absent"
            table.add_row(escape(check.name), verdict, escape(check.detail))
        make_console().print(table)
        if not failed:
            print("All that is needed works.")
    if failed:
        raise PilegraspError(f"these checks failed: {', '.join(failed)}")
