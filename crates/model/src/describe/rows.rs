//! Headings and aligned rows.

/// A longer cell does not move the cells of other rows.
const WIDEST: usize = 48;

/// A heading and aligned rows; empty columns take no room.
pub(super) fn section(out: &mut String, title: &str, rows: Vec<Vec<String>>) {
    out.push('\n');
    out.push_str(title);
    if rows.is_empty() && title != "modes" {
        out.push_str(": none");
    }
    out.push('\n');
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    // For each column whether it holds anything, and how wide it is.
    let widths = (0..columns).map(|i| {
        let cells = rows.iter().filter_map(|row| row.get(i));
        let lengths: Vec<usize> = cells.map(|cell| length(cell)).collect();
        let usual = lengths.iter().filter(|length| **length <= WIDEST).max();
        (
            lengths.iter().any(|length| *length > 0),
            usual.copied().unwrap_or(0),
        )
    });
    let widths: Vec<(bool, usize)> = widths.collect();
    for row in &rows {
        let mut line = String::from(" ");
        for (cell, (is_used, width)) in row.iter().zip(&widths) {
            if *is_used {
                line.push(' ');
                line.push_str(cell);
                line.push_str(&blanks(cell, *width));
                line.push(' ');
            }
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
}

pub(super) fn length(text: &str) -> usize {
    text.chars().count()
}

pub(super) fn blanks(text: &str, width: usize) -> String {
    " ".repeat(width.saturating_sub(length(text)))
}
