"""References over time: position, velocity and acceleration that agree with each other."""
