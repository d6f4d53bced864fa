//! Bisection, and the largest magnitude of numbers that may not be finite.

/// Halve the interval `ends` so many times and return the last half; `is_before` returns whether a number is before the one sought.
pub(crate) fn bisected(
    ends: [f64; 2],
    halvings: u32,
    mut is_before: impl FnMut(f64) -> bool,
) -> [f64; 2] {
    let [mut low, mut high] = ends;
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if is_before(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    [low, high]
}

/// Return the largest magnitude, zero without a value; not a number where one of the values is: `f64::max` would ignore it.
pub(crate) fn largest_magnitude(values: impl IntoIterator<Item = f64>) -> f64 {
    // The bits of magnitudes are in their order, those of NaN above all others.
    let bits = values.into_iter().map(|value| value.abs().to_bits());
    f64::from_bits(bits.max().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_half_contains_the_number_sought_in_either_direction() {
        assert_eq!(bisected([0.0, 1.0], 4, |x| x < 0.3), [0.25, 0.3125]);
        assert_eq!(bisected([0.0, -1.0], 4, |x| x > -0.3), [-0.25, -0.3125]);
    }

    #[test]
    fn a_value_that_is_not_a_number_makes_the_largest_one_so() {
        for place in 0..3 {
            let mut values = [1.0, -3.0, 2.0];
            assert_eq!(largest_magnitude(values), 3.0);
            values[place] = f64::NAN;
            assert!(largest_magnitude(values).is_nan(), "{place}");
        }
    }
}
