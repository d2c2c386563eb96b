"""The verdicts of a study of the paper as a Markdown table, for docs/results/README.md.

Usage: python results_table.py DIR, a folder of `pilegrasp paper`
"""

import json
from pathlib import Path

from pilegrasp_ctrl.statistics import markdown_table
from script import run_script


def row(claim: dict) -> list[str]:
    """Return a claim's cells: the paper's number, verdict, each part of the predicate with what was found, and why."""
    parts = "<br>".join(f"{part['statement']}: {part['verdict']}" for part in claim["parts"])
    cells = (claim["id"], claim["claim"], claim["paper"], f"**{claim['verdict']}**", parts, claim["explanation"])
    return [" ".join(cell.split()) for cell in cells]


def main(folder: Path) -> None:
    """Print what was run, then a line for each claim."""
    document = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    versions = ", ".join(f"{name} {version}" for name, version in document["versions"].items())
    print(f"`{document['command']}`, seeds from {document['seeds_from']}: {document['attempts']} attempts at ", end="")
    print(
        f"{document['conditions']} conditions, {document['processor_hours']:.1f} hours of processor time. {versions}.\n"
    )
    header = ("", "claim", "the paper", "verdict", "what was found", "why")
    print(markdown_table(header, (row(claim) for claim in document["claims"])))


if __name__ == "__main__":
    run_script(main)
