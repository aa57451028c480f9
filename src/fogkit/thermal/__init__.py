"""Temperature: a network of thermal masses to make it, models of its effect on a gyro, and which of them the data support."""
