"""From an observation and a reference to joint torques."""
