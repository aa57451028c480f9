"""From a record and an aid to heading: two Kalman filters and a smoother.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`records`           what does a gyrocompass record, and what does its aid say?
`runs`              what does a filter say of each state, and may one believe it?
`extended`          the thesis's filter: 15 errors about the computed state
`wander`            the filter to use: the Earth's axis for a state, consistent from any heading
`wander_estimates`  what that one says: its own states, and from them heading, trim and roll
`wander_model`      the error model of that one, and the rates that it is the derivative of
`smoother`          what do later measurements say of earlier times?
==================  =====================================================================================
"""
