//! Records in, results out.
