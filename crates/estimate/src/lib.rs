//! Set-valued estimation: the observer over a list of boxes.
