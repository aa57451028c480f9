"""Random errors of inertial sensors: make them, read them, name them (IEEE 952)."""
