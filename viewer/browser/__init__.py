"""The scripts that run in the browser: meshcat's viewer as its package ships it, and our own."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import json
from pathlib import Path

from pilegrasp_ctrl.exceptions import ExportError

PAGE_SCRIPTS = (
    "meshcat.js",
    "scene_view.js",
    "cameras.js",
    "hand.js",
    "arrows.js",
    "overlays.js",
    "chains.js",
    "tree.js",
    "signals.js",
    "numbers.js",
    "timeline.js",
    "panel.js",
    "page.js",
    "share.js",
)
"""Scripts of the page of an attempt, in the order in which they run."""

LIVE_SCRIPTS = ("meshcat.js", "scene_view.js", "hand.js", "numbers.js", "live_forces.js", "live.js")
"""Scripts of the live page, in the order in which they run."""

STUDY_SCRIPTS = ("pivot.js", "index.js")
"""Scripts of the page of a study, in the order in which they run."""

_HERE = Path(__file__).parent


def viewer_script() -> str:
    """Return meshcat's viewer with the licences of all that it bundles, read from the package without importing it.

    Raises:
        ExportError: Meshcat is not installed or has no viewer.
    """
    spec = importlib.util.find_spec("meshcat")
    if spec is None or spec.origin is None:
        raise ExportError("the page needs meshcat's viewer; install it with `pip install meshcat`")
    folder = Path(spec.origin).parent / "viewer"
    try:
        script = (folder / "dist" / "main.min.js").read_text(encoding="utf-8")
    except OSError as error:
        raise ExportError(f"meshcat's viewer cannot be read: {error}; install meshcat 0.3.2 again") from error
    notices = [folder / "LICENSE", folder / "dist" / "main.min.js.LICENSE.txt"]
    licence = "\n".join(file.read_text(encoding="utf-8") for file in notices if file.is_file())
    licence += _bundled_licences(folder / "dist" / "main.min.js.THIRD_PARTY_LICENSES.json")
    # The page contains no address, which shows a reader that it loads nothing.
    licence = licence.replace("https://", "").replace("http://", "").replace("*/", "").replace("/*", "")
    return f"/*!\nmeshcat and what it bundles:\n{licence}\n*/\n{script}"


def _bundled_licences(file: Path) -> str:
    """Return name, version, author and licence of each bundled package, equal texts once."""
    try:
        packages = json.loads(file.read_text(encoding="utf-8"))
        texts: dict[str, list[str]] = {}
        for package in packages:
            words = (str(package.get(key) or "") for key in ("name", "version", "author"))
            texts.setdefault(str(package.get("licenseText") or package.get("license")), []).append(" ".join(words))
    except (OSError, ValueError, AttributeError, TypeError):
        return ""
    return "".join(f"\n\n{', '.join(names)}:\n{text}" for text, names in texts.items())


def own_script(*names: str) -> str:
    """Return the joined text of scripts in this folder, without indentation and lines of comment."""
    lines = "".join((_HERE / name).read_text(encoding="utf-8") for name in names).splitlines()
    return "".join(f"{text}\n" for line in lines if (text := line.strip()) and not text.startswith("//"))


def digest(script: str) -> str:
    """Return the source expression by which a content security policy allows exactly this script."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
