"""Where a unit is and how it stands, from what its gyros and accelerometers read."""
