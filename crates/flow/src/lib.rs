//! Validated integration of one step across mode switches.
