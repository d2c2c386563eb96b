"""`pilegrasp check`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape
from rich.table import Table

from ..exceptions import ConfigurationError, PilegraspError
from ..files import check_output
from ..plugins import use_plugins
from .application import DebugOption, JsonOption, PluginsOption, app, make_console, print_json, with_examples

if TYPE_CHECKING:
    from ..validation.check.registry import Finding

BESIDE = "."
"""Value of `--write` without a folder: the pieces of a part are stored beside its mesh."""

PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of the picture."""


class BareWrite(typer.core.TyperCommand):
    """A command whose `--write` may stand without a folder, as in `pilegrasp check PART --write`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Give a bare `--write` the folder in which things are by default."""
        following = [*args[1:], "--"]
        bare = [arg == "--write" and after.startswith("-") for arg, after in zip(args, following, strict=True)]
        return super().parse_args(
            ctx, [f"{arg}={BESIDE}" if alone else arg for arg, alone in zip(args, bare, strict=True)]
        )


@app.command(
    "check",
    cls=BareWrite,
    epilog=with_examples(
        'A folder that was made is an arm of a scenario: `robot = "./arm"`.',
        "pilegrasp check spheres_wall --picture poses.png",
        "pilegrasp check bracket.toml --write",
        "pilegrasp check arm.urdf --tool-frame flange --joints 7 --write arm",
    ),
)
def check(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME|FILE|FOLDER",
            help="A scenario, arm, hand or object, by its name, file or folder; or a bare URDF or MJCF.",
        ),
    ],
    tool_frame: Annotated[
        str | None,
        typer.Option("--tool-frame", metavar="F", help="Link, body or site of a bare model that carries the hand."),
    ] = None,
    joints: Annotated[
        int | None, typer.Option("--joints", metavar="N", min=1, help="First N joints of a bare model; all by default.")
    ] = None,
    write: Annotated[
        Path | None,
        typer.Option(
            "--write",
            metavar="[DIR]",
            help="Make the folder of an arm from a bare model; for an object, store its convex pieces beside its mesh.",
        ),
    ] = None,
    hand: Annotated[
        list[str] | None,
        typer.Option("--hand", metavar="H", help="Hand with which an arm is checked; rbo_hand2 and shovel by default."),
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="F.png", help="Draw a scenario's planned start, touch-down and end."),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, metavar="S", help="Seed of a scenario's pile.")] = 0,
    overrides: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Replace a key of a scenario.")
    ] = None,
    plugins: PluginsOption = None,
    as_json: JsonOption = False,
    debug: DebugOption = False,
) -> None:
    """Say what is missing, out of reach, in collision, too heavy or not covered, before anything runs."""
    use_plugins(plugins or ())
    from ..validation.check.registry import Subject, findings
    from ..validation.check.subjects import kind_of

    kind = kind_of(name)
    _check_options(kind, tool_frame, joints, write, picture, seed, overrides)
    if picture is not None:
        check_output(picture, *PICTURES)
    hands = tuple(hand) if hand else ("rbo_hand2", "shovel")
    found: list[Finding] = []
    if write is not None and kind == "part":
        found += _store(Path(name))
    elif write is not None:
        found += _write(Path(name), tool_frame or "", joints, write, hands)
        kind, name = "arm", str(write)
    subject = Subject(
        kind,
        name,
        hands,
        seed,
        picture,
        tuple(overrides or ()),
        tool_frame if kind == "model" else None,
        joints if kind == "model" else None,
    )
    found += findings(subject)
    problems = [finding for finding in found if finding.level == "problem"]
    if as_json:
        print_json({"name": name, "kind": kind, "ok": not problems, "findings": [each._asdict() for each in found]})
    else:
        make_console().print(_table(found))
        if not problems:
            print("Nothing prevents a run.")
    if problems:
        raise PilegraspError(f"{name}: {'; '.join(problem.text for problem in problems)}")


def _check_options(
    kind: str,
    tool_frame: str | None,
    joints: int | None,
    write: Path | None,
    picture: Path | None,
    seed: int,
    overrides: list[str] | None,
) -> None:
    """Refuse options that the kind of subject does not read."""
    for option, given, kinds in (
        ("--tool-frame", tool_frame, "model"),
        ("--joints", joints, "model"),
        ("--write", write if kind != "part" else None, "model"),
        ("--picture", picture, "scenario"),
        ("--set", overrides, "scenario"),
        ("--seed", seed or None, "scenario"),
    ):
        if given is not None and kind != kinds:
            what = "a bare URDF or MJCF" if kinds == "model" else "a scenario"
            raise ConfigurationError(f"{option} is for {what}, and this is {name_of(kind)}; leave it out")
    if kind == "part":
        if write is not None and write != Path(BESIDE):
            raise ConfigurationError(
                f"--write {write}: the pieces of an object stand beside its mesh; leave the folder out"
            )
        return
    if write is not None and tool_frame is None:
        raise ConfigurationError("--write needs --tool-frame, the frame that carries the hand; give both")


def name_of(kind: str) -> str:
    """Return a kind of subject with its article."""
    return f"an {kind}" if kind == "arm" else f"a {kind}"


def _write(file: Path, tool_frame: str, joints: int | None, folder: Path, hands: tuple[str, ...]) -> list[Finding]:
    from ..validation.check.arm_folder import write_arm_folder
    from ..validation.check.registry import Finding

    made = write_arm_folder(file, tool_frame, joints, folder, hands)
    found = [Finding("fact", "folder", f"{made.folder} holds the arm; read its robot.toml and correct what you know")]
    if made.left_out:
        found.append(Finding("note", "folder", f"what {tool_frame} carries is left out: {', '.join(made.left_out)}"))
    return found


def _store(file: Path) -> list[Finding]:
    from ..validation.check.part import store_pieces
    from ..validation.check.registry import Finding

    if file.suffix.lower() != ".toml":
        raise ConfigurationError(f"{file}: --write needs the .toml file of an object of yours")
    stored = store_pieces(file)
    if not stored:
        return [Finding("fact", "pieces", "nothing is stored, because no mesh of it needs convex pieces")]
    return [Finding("fact", "pieces", f"{path} holds the convex pieces; keep it beside the mesh") for path in stored]


def _table(found: list[Finding]) -> Table:
    colors = {"problem": "[red]problem", "note": "[yellow]note", "fact": "[green]ok"}
    table = Table(box=None, pad_edge=False)
    for column in ("", "about", "sentence"):
        table.add_column(column)
    for finding in found:
        table.add_row(colors[finding.level], escape(finding.about), escape(finding.text))
    return table
