//! Sound interval arithmetic: directed rounding, elementary functions, exact decimal text.
