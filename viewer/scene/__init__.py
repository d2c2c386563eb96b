"""The scene of a recording as commands of meshcat's viewer: shapes, motion, overlays and camera."""
