"""From the geometry of scene, hand and pile to the line of a push. No engine."""
