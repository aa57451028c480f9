"""Gyrocompass of three gyros on a mount that turns them about the deck's normal.

======================  ================================================================================================
module                  answers
======================  ================================================================================================
`frames`                which axes has the thesis, which the package, and how does one come to the other?
`mechanisation`         what do gyro readings, the mount's angle and specific force say of attitude, velocity, position?
`error_model`           how do errors of these grow, and what does aiding see of them?
`laws`                  how does the mount turn, and how fast must it be sampled?
`gyro_range`            what does a law ask of the gyros?
`encoder`               what does the mount's angle sensor say of that?
`accuracy`              how well can heading be known at best, under any law?
`motions`               what does a vessel do, and what do its sensors then read?
`covariance`            how well is each state known over a motion, with an aid?
`observability`         which combinations of states does an aid see at all?
`velocity_information`  what do velocities alone say of heading, and what spoils it when they are poor?
`filters`               what do a record and an aid say of heading, and may one believe it?
`scan`                  what does a scan of the Earth rate at rest say, and what does it leave open?
`dwells`                where in a raw record of a scan does the unit stand, and what does it read there?
`tables`                how does a record become a table, and a table a record?
`design`                how well do gyros, mount, latitude and time give heading, and which part is the weakest?
`design_needs`          which gyros, or how much time, does a heading take?
`design_inputs`         which numbers does a design start from?
`design_noise`          what is left of gyro noise of any colour under a law?
`design_laws`           which law is the best within what a mount can do?
`mount_scale`           what do the turns of the mount say of the gyros' scale factors?
======================  ================================================================================================
"""
