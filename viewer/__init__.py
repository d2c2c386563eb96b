"""Recordings as pages: one HTML file with scene, motion and forces, opened without a server or a network."""

from pilegrasp_ctrl.viewer.html import page, write_html

__all__ = ["page", "write_html"]
