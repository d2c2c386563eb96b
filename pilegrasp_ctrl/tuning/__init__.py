"""The search over gains: which gains are tried, how they are judged, and the page that shows the result."""
