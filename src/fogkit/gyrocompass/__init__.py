"""Gyrocompass of three gyros on a mount that turns them about the deck's normal.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`frames`            which axes has the thesis, which the package, and how does one come to the other?
`mechanisation`     what do gyro readings, the mount's angle and specific force say of attitude, velocity, position?
`error_model`       how do errors of these grow, and what does aiding see of them?
`laws`              how does the mount turn, and how fast must it be sampled?
`gyro_range`        what does a law ask of the gyros?
`encoder`           what does the mount's angle sensor say of that?
`accuracy`          how well can heading be known at best, under any law?
`motions`           what does a vessel do, and what do its sensors then read?
`covariance`        how well is each state known over a motion, with an aid?
`filters`           what do a record and an aid say of heading, and may one believe it?
`scan`              what does a scan of the Earth rate at rest say, and what does it leave open?
`dwells`            which samples of a raw record are readings of a scan, and what are their means?
`mount_scale`       what do the turns of the mount say of the gyros' scale factors?
`tables`            how do one's own recording and aid come into the filters?
==================  =====================================================================================
"""
