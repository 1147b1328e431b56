//! Bars on stderr for what takes long; none where nobody watches.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// Parts of a bar over a stretch of time.
pub const PARTS: u64 = 1000;

/// A bar over so many samples.
pub fn of_samples(count: usize, quiet: bool) -> ProgressBar {
    let form = "  [{bar:24}] {pos} of {len} samples, {eta} left";
    bar(count as u64, form, quiet)
}

/// A bar over a whole of so many parts; `what` is done meanwhile.
pub fn of_parts(count: u64, what: &str, quiet: bool) -> ProgressBar {
    let form = format!("  [{{bar:24}}] {{percent}} % {what}, {{eta}} left");
    bar(count, &form, quiet)
}

/// A line that says where a run stands whose length nobody knows.
pub fn of_standing(quiet: bool) -> ProgressBar {
    bar(1, "  {msg}", quiet)
}

fn bar(length: u64, form: &str, quiet: bool) -> ProgressBar {
    let target = if quiet || !std::io::stderr().is_terminal() {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr_with_hz(5)
    };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template(form) {
        bar.set_style(style.progress_chars("##-"));
    }
    bar
}
