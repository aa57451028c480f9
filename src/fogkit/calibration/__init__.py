"""How well a gyro must be calibrated, and how that is done on a rate table.

`fogkit.calibration.requirements` turns the drift that is allowed into what scale factors, angles and the table must be
known to, and back.
"""
