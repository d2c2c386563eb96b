"""Recordings as pages, pictures and movies: one HTML file opened without a server or a network, PNG, GIF, MP4."""

from pilegrasp_ctrl.viewer.exports import require_programs, write
from pilegrasp_ctrl.viewer.page.document import page, write_html

__all__ = ["page", "require_programs", "write", "write_html"]
