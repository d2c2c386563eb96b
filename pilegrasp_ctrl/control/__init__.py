"""Controllers: they turn an observation and a reference into joint torques."""
