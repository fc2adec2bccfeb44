//! Laws of friction and normal contact: pure functions of state and speed, generic over the scalar.
