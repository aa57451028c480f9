"""Temperature: a thermal network, models of its effect on a gyro, and which of them the data support."""
