"""The motion pattern of the paper's section III, measured from recordings: `measure` and `annotate`."""

from .measures import annotate, measure

__all__ = ["annotate", "measure"]
