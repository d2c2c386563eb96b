"""The search over gains: what is tried, how it is judged, and the page that shows it."""
