"""The live page: an attempt in the browser while it runs."""

from pilegrasp_ctrl.viewer.live.live_view import FIRST_PAGE_TIMEOUT, LiveView

__all__ = ["FIRST_PAGE_TIMEOUT", "LiveView"]
