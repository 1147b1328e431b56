//! Which of the names that exist did the user mean?

/// The name in `names` closest to `wanted`, where one is close at all.
pub(crate) fn closest<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let ranked = names.filter_map(|name| Some((rank(wanted, name)?, name)));
    ranked.min_by_key(|(rank, _)| *rank).map(|(_, name)| name)
}

/// Smaller is closer; `None` is not similar.
fn rank(wanted: &str, name: &str) -> Option<usize> {
    let (wanted, name) = (wanted.to_lowercase(), name.to_lowercase());
    let longer = wanted.chars().count().max(name.chars().count());
    let edits = distance(&wanted, &name);
    if edits * 3 <= longer {
        return Some(edits);
    }
    if wanted.len().min(name.len()) >= 3 && (wanted.contains(&name) || name.contains(&wanted)) {
        return Some(longer + edits);
    }
    // `phi_m` and `phi_meas_rad`: the same first word.
    let first = |text: &str| {
        text.split(['_', ' ', '.', '['])
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    let (one, other) = (first(&wanted), first(&name));
    (!one.is_empty() && one == other).then_some(longer + edits)
}

/// Number of characters to insert, remove or replace.
fn distance(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (above, c) in one.chars().enumerate() {
        let mut next = vec![above + 1];
        for ((d, pair), left_of) in other.iter().zip(row.windows(2)).zip(0..) {
            let (replace, remove) = match pair {
                [replace, remove] => (*replace, *remove),
                _ => continue,
            };
            let insert = next.get(left_of).copied().unwrap_or(usize::MAX - 1);
            let replace = replace + usize::from(*d != c);
            next.push(replace.min(remove + 1).min(insert + 1));
        }
        row = next;
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("abc", ""), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("still", "still"), 0);
    }

    #[test]
    fn the_closest_name_is_found_or_none() {
        let names = ["t_s", "u_Nm", "phi_meas_rad", "standstill"];
        let closest = |wanted| closest(wanted, names.into_iter());
        assert_eq!(closest("phi_m"), Some("phi_meas_rad"));
        assert_eq!(closest("U_nm"), Some("u_Nm"));
        assert_eq!(closest("standstil"), Some("standstill"));
        assert_eq!(closest("still"), Some("standstill"));
        assert_eq!(closest("alpha"), None);
    }
}
