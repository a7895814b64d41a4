"""Visual servoing: a head that follows what its camera sees, an arm that reaches for a marker.

Detection, control and the state machine are plain computation: time is an argument, nothing here reads a
clock or moves anything. `robots` says what a robot is, `runner` runs the loop on threads.
"""
