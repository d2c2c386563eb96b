"""Print the verdicts of a study of the paper as the Markdown table of docs/results/README.md.

Usage: python docs/studies/results_table.py DIR, a folder of `pilegrasp paper`
"""

import json
from pathlib import Path

from pilegrasp_ctrl.statistics import markdown_table
from script import run_script


def row(claim: dict) -> list[str]:
    """Return the cells of a claim: the paper's number, the verdict, each part of the predicate, and the reason."""
    parts = "<br>".join(f"{part['statement']}: {part['verdict']}" for part in claim["parts"])
    cells = (claim["id"], claim["claim"], claim["paper"], f"**{claim['verdict']}**", parts, claim["explanation"])
    return [" ".join(cell.split()) for cell in cells]


def main(folder: Path) -> None:
    """Print the study's command and size, then a line for each claim."""
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
