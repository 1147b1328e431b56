//! Proved parameter and state bounds for dynamic systems.
