"""Planning from the geometry of scene, hand and pile to the line of a push, without a physics engine."""
