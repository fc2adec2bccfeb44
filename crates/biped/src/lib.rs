//! Planar biped: rigid-body dynamics, foot contact, force envelope, the gait problem.
