//! Errors of descriptions and runs, each with the numbers that show the cause.

use thiserror::Error;

/// Reason of a failure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Error {
    /// A field of a description has an invalid value.
    #[error("{field} = {value}: {expected}")]
    InvalidValue {
        /// Type and field, as in `Chain.pitch`.
        field: String,
        /// The value, as text.
        value: String,
        /// Permitted values, and a remedy if there is one.
        expected: String,
    },
    /// The parts of a description are incompatible.
    #[error("{0}")]
    Impossible(String),
    /// The step size fell to the level of rounding.
    #[error(
        "step size fell to {step_size:.1e} s, the level of rounding, at t = {time:.9} s, {culprit}; check the inputs of this part, \
         or raise rtol and atol, or accuracy where they are not given"
    )]
    StepTooSmall {
        /// Time reached \[s\].
        time: f64,
        /// Size of the failed step \[s\].
        step_size: f64,
        /// Body with the largest error, and its contact.
        culprit: String,
    },
    /// The predicted number of steps of the run exceeds the limit.
    #[error(
        "steps have fallen to {step_size:.1e} s on average at t = {time:.9} s, {culprit}: one second, or the rest of the run, would \
         take more than {most_steps:e} steps; look for a mass, inertia, force, gravity or viscosity that is orders of magnitude \
         from a real one, raise min_impact_velocity or the tolerances, or max_step where that limits the steps, or run a shorter time"
    )]
    Standstill {
        /// Time reached \[s\].
        time: f64,
        /// Mean size of the last steps \[s\].
        step_size: f64,
        /// Limit on the number of steps.
        most_steps: f64,
        /// Contact with the largest force.
        culprit: String,
    },
    /// Forces or positions are not finite.
    #[error(
        "the solution is not a number within {step_size:.1e} s after t = {time:.9} s, {culprit}; check masses, forces and functions \
         of this part"
    )]
    NotFinite {
        /// Time reached \[s\].
        time: f64,
        /// Size of the failed step \[s\].
        step_size: f64,
        /// First body with a value that is not finite, and its contact.
        culprit: String,
    },
    /// The tolerances are below what rounding permits.
    #[error(
        "tolerances are below what rounding allows at t = {time:.9} s, where a coordinate or its rate is {value:.3e}, {culprit}: \
         raise rtol or atol, or accuracy where they are not given, at least {:.2} times; a coordinate that grows, such as the angle of a \
         rotor, needs more", .factor.max(1.01)
    )]
    ToleranceTooSmall {
        /// Time reached \[s\].
        time: f64,
        /// Size of the next step \[s\].
        step_size: f64,
        /// Factor by which both tolerances must grow.
        factor: f64,
        /// Coordinate, or its rate, with the largest ratio of state to tolerance.
        value: f64,
        /// Body with the largest ratio of state to tolerance, and its contact.
        culprit: String,
    },
    /// The joint constraints of a mechanism are no longer compatible.
    #[error(
        "no positions satisfy all joints after t = {time:.9} s; the nearest miss {residuals}: the mechanism is jammed or driven \
         beyond its range, or rtol and atol are too large"
    )]
    JointsApart {
        /// Time reached \[s\].
        time: f64,
        /// Largest residuals, by joint.
        residuals: String,
    },
    /// A panic occurred, which is a defect of this crate.
    #[error("defect of rustchain{}: {message}; please report it with the scene", at(*.time))]
    Panicked {
        /// Time reached in a run \[s\], if a run was active.
        time: Option<f64>,
        /// Message of the panic, with its source location if recorded.
        message: String,
    },
}

impl Error {
    /// Return the error of a field with an invalid value.
    #[allow(clippy::needless_pass_by_value)] // accepts numbers and text
    pub fn invalid(
        field: impl Into<String>,
        value: impl ToString,
        expected: impl Into<String>,
    ) -> Self {
        Self::InvalidValue {
            field: field.into(),
            value: on_one_line(with_exponents(&value.to_string())),
            expected: with_exponents(&expected.into()),
        }
    }
}

/// Maximum number of characters of a number written without an exponent.
const LONGEST_NUMBER: usize = 24;

/// Maximum number of characters of a value in a message, one line of a terminal. The Python package has the same number.
const LONGEST_VALUE: usize = 80;

/// Maximum number of names in a message.
const MOST_NAMES: usize = 8;

/// Return a text whose numbers of hundreds of digits have an exponent.
fn with_exponents(text: &str) -> String {
    let ends_number = |c: char| c.is_whitespace() || "(),;:".contains(c);
    let words = text.split_inclusive(ends_number);
    let word = |word: &str| {
        let number = word.trim_end_matches(ends_number);
        match number.parse::<f64>() {
            Ok(value) if number.len() > LONGEST_NUMBER && value.is_finite() => {
                format!("{value:e}{}", &word[number.len()..])
            }
            _ => word.to_string(),
        }
    };
    words.map(word).collect()
}

/// Return a text on one line of at most 80 characters.
fn on_one_line(text: String) -> String {
    if text.chars().take(LONGEST_VALUE + 1).count() > LONGEST_VALUE || text.contains('\n') {
        return shortened(&text);
    }
    text
}

/// Return names in quotes, for a message: the first eight, and how many more there are.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let first: Vec<String> = (names.by_ref().take(MOST_NAMES))
        .map(|name| format!("{name:?}"))
        .collect();
    let first = first.join(", ");
    match names.count() {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// Return a number with so many digits behind the point; zero has no sign.
pub(crate) fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(zero) if !zero.contains(|c| ('1'..='9').contains(&c)) => zero.to_string(),
        _ => text,
    }
}

/// Return two components as [`decimal`] numbers in parentheses.
pub(crate) fn pair(components: impl Into<[f64; 2]>, digits: usize) -> String {
    let [x, y] = components.into().map(|value| decimal(value, digits));
    format!("({x}, {y})")
}

/// Return the time of an error in a run, in words.
fn at(time: Option<f64>) -> String {
    time.map_or(String::new(), |time| format!(" at t = {time:.9} s"))
}

/// Return the beginning of a text, with its lines joined.
fn shortened(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().take(LONGEST_VALUE).collect();
    let line = words.join(" ");
    if line.chars().count() <= LONGEST_VALUE {
        return line;
    }
    let kept: String = line.chars().take(LONGEST_VALUE - 3).collect();
    format!("{kept}...")
}

/// Result with the error type of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Checks shared by the descriptions; each error has the field, the value and the permitted range.
pub(crate) mod check {
    use super::{Error, Result};

    /// Check that a value is finite and positive.
    pub(crate) fn positive(field: &str, value: f64, unit: &str) -> Result<()> {
        if value.is_finite() && value > 0.0 {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            value,
            format!("must be a positive number in {unit}"),
        ))
    }

    /// Check that a value is finite and not negative.
    pub(crate) fn not_negative(field: &str, value: f64, unit: &str) -> Result<()> {
        if value.is_finite() && value >= 0.0 {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            value,
            format!("must be zero or a positive number in {unit}"),
        ))
    }

    /// Check that a value is neither infinite nor NaN.
    pub(crate) fn finite(field: &str, value: f64, unit: &str) -> Result<()> {
        if value.is_finite() {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            value,
            format!("must be a finite number in {unit}"),
        ))
    }

    /// Check both coordinates of a point \[m\].
    pub(crate) fn point(field: &str, point: impl Into<[f64; 2]>) -> Result<()> {
        let [x, y] = point.into();
        finite(&format!("{field} (x)"), x, "m")?;
        finite(&format!("{field} (y)"), y, "m")
    }

    /// Check that a vector has a direction.
    pub(crate) fn direction(field: &str, vector: impl Into<[f64; 2]>) -> Result<()> {
        let [x, y] = vector.into();
        let length = (x * x + y * y).sqrt();
        if length.is_finite() && length > 0.0 {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            format!("({x}, {y})"),
            "must be a direction: two finite numbers, not both zero",
        ))
    }

    /// Check that a value lies within a closed range.
    pub(crate) fn within(field: &str, value: f64, low: f64, high: f64) -> Result<()> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            value,
            format!("must be between {low} and {high}"),
        ))
    }

    /// Check that there is a row for each of `bodies` bodies.
    pub(crate) fn rows(field: &str, rows: &[[f64; 3]], bodies: usize) -> Result<()> {
        if rows.len() == bodies {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            format!("{} rows", rows.len()),
            format!("needs one row (3 numbers) for each of the {bodies} bodies"),
        ))
    }

    /// Check that there is a row of finite numbers for each of the bodies, which have these names.
    pub(crate) fn finite_rows(field: &str, rows: &[[f64; 3]], names: &[String]) -> Result<()> {
        self::rows(field, rows, names.len())?;
        for (name, row) in names.iter().zip(rows) {
            if let Some(bad) = row.iter().find(|value| !value.is_finite()) {
                let field = format!("{field} of {name}");
                return Err(Error::invalid(field, bad, "must be finite numbers"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Error, pair};

    #[test]
    fn a_value_is_said_as_it_was_written() {
        let said = |value: f64| Error::invalid("step", value, "is odd").to_string();
        assert_eq!(said(0.1 + 0.2), "step = 0.30000000000000004: is odd");
        assert_eq!(said(1e-300), "step = 1e-300: is odd");
        assert_eq!(said(-f64::MAX), "step = -1.7976931348623157e308: is odd");
        assert_eq!(said(f64::NAN), "step = NaN: is odd");
        let name = "a sprocket of forty characters or so".to_string();
        let error = Error::invalid("name", &name, "is odd");
        assert_eq!(error.to_string(), format!("name = {name}: is odd"));
    }

    #[test]
    fn long_numbers_within_a_text_have_exponents() {
        let point = format!("({}, {})", 1e300, -1e-300);
        let expected = format!("must be below {} m: it is large", f64::MAX);
        let error = Error::invalid("point", point, expected);
        assert_eq!(
            error.to_string(),
            "point = (1e300, -1e-300): must be below 1.7976931348623157e308 m: it is large"
        );
    }

    #[test]
    fn zeros_of_a_pair_have_no_sign() {
        assert_eq!(pair([-1e-9, -0.5], 4), "(0.0000, -0.5000)");
    }

    #[test]
    fn a_value_of_many_lines_is_said_on_one_line_of_eighty_characters() {
        let said = |value: &str| Error::invalid("name", value, "is odd").to_string();
        assert_eq!(said("two\n  lines"), "name = two lines: is odd");
        let long = said(&"é".repeat(5000));
        assert_eq!(long, format!("name = {}...: is odd", "é".repeat(77)));
        assert_eq!(
            said(&"9".repeat(400)),
            format!("name = {}...: is odd", "9".repeat(77))
        );
    }
}
