"""Columns of the tables in which readings of a measurement unit come and go; the index is ``time``, s."""

GYRO_COLUMNS = ("gyro_x", "gyro_y", "gyro_z")
ACCEL_COLUMNS = ("accel_x", "accel_y", "accel_z")
IMU_COLUMNS = GYRO_COLUMNS + ACCEL_COLUMNS
