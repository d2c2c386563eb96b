"""Pictures and movies, which a Chromium without a window draws from the page."""
