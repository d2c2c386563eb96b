"""An arm without a physics engine: simulation, responses and tracking of any controller."""
