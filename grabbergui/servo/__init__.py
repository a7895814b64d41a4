"""Visual servoing: a head that follows what its camera sees, an arm that reaches for a marker.

Tracking, control and the state machine are plain computation: time is an argument, nothing in them reads a
clock or moves anything. `robots` says what a robot is, `runner` runs the loop on threads; every motion passes
the `gate`, and a `guardian` in a process of its own stops the robot if this one cannot.
"""
