"""How well an inertial measurement unit must be calibrated, and how that is done.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`requirements`      which scale factors, angles and table does an allowed drift need?
`three_stage`       three-axis table: how do three stages give the parameters of a gyro triad?
`bench_fit`         three-axis table: what do all positions and turns say at once?
`multiposition`     plate: what do six positions, 24 points, or any others say of gyros and accelerometers?
`rate_sequence`     single-axis table: what do a list of rates and positions to the east say of gyros?
`velocity_noise`    what do random errors of sensors do to slopes of the computed velocity?
`uncertainty`       navigation-based: how sure are the estimates, truly?
`turn_plans`        navigation-based: which tests, how many turns, how long a dwell?
`accuracy`          what is left of a scale factor and a direction, from a budget of errors?
`plan_design`       which plan gives the most?
`triad`             the record of a calibrated gyro triad
==================  =====================================================================================
"""
