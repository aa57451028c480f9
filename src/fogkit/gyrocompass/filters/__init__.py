"""From a record and an aid to heading: two Kalman filters and a smoother.

==================  =====================================================================================
module              answers
==================  =====================================================================================
`records`           what does a gyrocompass record, and what does its aid say?
`runs`              what does a filter say of each state, and may one believe it?
`extended`          the thesis's filter: 15 errors about the computed state
`wander`            the filter to use: the Earth's axis for a state, consistent from any heading
`smoother`          what do later measurements say of earlier times?
==================  =====================================================================================
"""
