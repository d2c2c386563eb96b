"""The colours of the figures: real ones for files, and names that a page gives its own light and dark colours."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours by what they mean; `first` to `third` tell series apart (blue, yellow, green, as in the paper)."""

    ink: str
    soft: str
    rule: str
    first: str
    second: str
    third: str
    fourth: str
    paper: str

    def style(self) -> dict[str, object]:
        """Return matplotlib's settings."""
        return {
            "svg.fonttype": "none",
            "svg.hashsalt": "pilegrasp",
            "font.family": "sans-serif",
            "font.size": 9.0,
            "text.color": self.ink,
            "axes.edgecolor": self.rule,
            "axes.labelcolor": self.soft,
            "axes.facecolor": "none",
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.titlesize": 9.0,
            "axes.titlecolor": self.ink,
            "xtick.color": self.soft,
            "ytick.color": self.soft,
            "grid.color": self.rule,
            "grid.linewidth": 0.6,
            "legend.frameon": False,
            "legend.fontsize": 8.0,
            "legend.labelcolor": self.ink,
            "lines.linewidth": 1.6,
            "figure.constrained_layout.use": True,
        }

    def items(self) -> list[tuple[str, str]]:
        """Return names and colours."""
        return [(field.name, getattr(self, field.name)) for field in fields(self)]


LIGHT = Palette("#1d2126", "#646b74", "#d9dce0", "#2166c4", "#c98a00", "#2a8a4a", "#b3261e", "#7b3fb5")
NAMED = Palette("#010203", "#010204", "#010205", "#010206", "#010207", "#010208", "#010209", "#01020a")
"""Colours that nothing else has; in a page each becomes `var(--name)`, so that one drawing serves light and dark."""
