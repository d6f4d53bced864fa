//! Reader of a description object by field, with the types of its values.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyInt, PyString, PyTuple};

use crate::drive::TEETH;
use crate::error::{Error, check};
use crate::geometry::Vec2;
use crate::math::{Signal, Spline, Table};

/// Description object with fields read by name.
pub(crate) struct Reader<'a, 'py> {
    object: &'a Bound<'py, PyAny>,
    pub(crate) kind: String,
}

impl<'a, 'py> Reader<'a, 'py> {
    /// Return a reader of `object`, which must be a description of one of the `kinds`.
    pub(crate) fn new(
        object: &'a Bound<'py, PyAny>,
        field: &str,
        kinds: &[&str],
    ) -> PyResult<Self> {
        let read = Self::of(object);
        if kinds.contains(&read.kind.as_str()) {
            return Ok(read);
        }
        Err(refuse(
            field,
            object,
            &format!("must be {}", with_articles(kinds)),
        ))
    }

    /// Return a reader of an object of any class.
    pub(super) fn of(object: &'a Bound<'py, PyAny>) -> Self {
        let kind = kind_of(object);
        Self { object, kind }
    }

    pub(super) fn name(&self, field: &str) -> String {
        format!("{}.{field}", self.kind)
    }

    pub(crate) fn get(&self, field: &str) -> PyResult<Bound<'py, PyAny>> {
        self.object.getattr(field)
    }

    pub(crate) fn number(&self, field: &str, unit: &str) -> PyResult<f64> {
        self.part(field, |value, name| number(value, name, unit))
    }

    pub(crate) fn optional_number(&self, field: &str, unit: &str) -> PyResult<Option<f64>> {
        self.optional(field, |value, name| number(value, name, unit))
    }

    /// Read a field with `of`, which gets the value and its name.
    pub(super) fn part<T>(
        &self,
        field: &str,
        of: impl FnOnce(&Bound<'py, PyAny>, &str) -> PyResult<T>,
    ) -> PyResult<T> {
        of(&self.get(field)?, &self.name(field))
    }

    /// Read a field as [`Self::part`]; none where it is Python's `None`.
    pub(super) fn optional<T>(
        &self,
        field: &str,
        of: impl FnOnce(&Bound<'py, PyAny>, &str) -> PyResult<T>,
    ) -> PyResult<Option<T>> {
        self.part(field, |value, name| {
            let given = (!value.is_none()).then(|| of(value, name));
            given.transpose()
        })
    }

    /// Read a tuple, each item with `of`, which gets the item and its name with a number from 1; `expected` is for another type.
    pub(super) fn sequence<T>(
        &self,
        field: &str,
        expected: &str,
        of: impl Fn(&Bound<'py, PyAny>, &str) -> PyResult<T>,
    ) -> PyResult<Vec<T>> {
        let (value, name) = (self.get(field)?, self.name(field));
        let Ok(items) = value.cast::<PyTuple>() else {
            return Err(refuse(&name, &value, expected));
        };
        let item = |(i, item)| of(&item, &format!("{name}.{}", i + 1));
        items.iter().enumerate().map(item).collect()
    }

    /// Read rows of a count and a number; `expected` is for other rows.
    pub(super) fn counted_rows(
        &self,
        field: &str,
        expected: &str,
        unit: &str,
    ) -> PyResult<Vec<(u32, f64)>> {
        let name = self.name(field);
        self.sequence(field, expected, |row, _| {
            let Ok([first, second]) = row.extract::<[Bound<'_, PyAny>; 2]>() else {
                return Err(refuse(&name, row, expected));
            };
            Ok((count(&first, &name)?, number(&second, &name, unit)?))
        })
    }

    /// Check that a display name is text; it has no other use here.
    pub(super) fn check_text(&self, field: &str) -> PyResult<()> {
        let value = self.get(field)?;
        if value.is_instance_of::<PyString>() {
            return Ok(());
        }
        Err(refuse(&self.name(field), &value, "must be text"))
    }

    /// Read a number, or a tuple of numbers.
    pub(super) fn numbers(&self, field: &str, unit: &str) -> PyResult<Vec<f64>> {
        let value = self.get(field)?;
        let name = self.name(field);
        let Ok(row) = value.cast::<PyTuple>() else {
            return Ok(vec![number(&value, &name, unit)?]);
        };
        row.iter().map(|each| number(&each, &name, unit)).collect()
    }

    pub(super) fn count(&self, field: &str) -> PyResult<u32> {
        self.part(field, count)
    }

    pub(crate) fn vector(&self, field: &str, unit: &str) -> PyResult<Vec2> {
        let value = self.get(field)?;
        if let Ok(pair) = value.cast::<PyTuple>()
            && pair.len() == 2
        {
            let name = self.name(field);
            return Ok(Vec2::new(
                number(&pair.get_item(0)?, &format!("{name} (x)"), unit)?,
                number(&pair.get_item(1)?, &format!("{name} (y)"), unit)?,
            ));
        }
        Err(refuse(
            &self.name(field),
            &value,
            &match unit {
                "1" => "must be two numbers (x, y)".to_string(),
                unit => format!("must be two numbers (x, y) in {unit}"),
            },
        ))
    }

    pub(super) fn optional_vector(&self, field: &str, unit: &str) -> PyResult<Option<Vec2>> {
        self.optional(field, |_, _| self.vector(field, unit))
    }

    /// Read one of several words, each with a value; Python's `None` is the word "None".
    pub(crate) fn word<T: Copy>(&self, field: &str, words: &[(&str, T)]) -> PyResult<T> {
        let value = self.get(field)?;
        let text = if value.is_none() {
            "None".to_string()
        } else {
            value.extract::<String>().unwrap_or_default()
        };
        if let Some((_, found)) = words.iter().find(|(word, _)| *word == text) {
            return Ok(*found);
        }
        let allowed: Vec<String> = words
            .iter()
            .map(|(word, _)| {
                if *word == "None" {
                    "None".to_string()
                } else {
                    format!("\"{word}\"")
                }
            })
            .collect();
        Err(refuse(
            &self.name(field),
            &value,
            &format!("must be {}", allowed.join(" or ")),
        ))
    }

    pub(super) fn signal(&self, field: &str, unit: &str) -> PyResult<Signal> {
        self.part(field, |value, name| signal(value, name, unit))
    }
}

/// Classes of signals.
pub(super) const SIGNALS: [&str; 4] = ["SmoothStep", "Table", "Spline", "Sines"];

/// Read a function of time: a number, rows (time, value), or one of the signal classes.
pub(crate) fn signal(value: &Bound<'_, PyAny>, name: &str, unit: &str) -> PyResult<Signal> {
    let axis = ("time", "s");
    if let Ok(tuple) = value.cast::<PyTuple>() {
        let rows = rows(tuple, name, axis, unit)?;
        return Ok(Signal::Table(Table::new(name, unit, &rows)?));
    }
    let kind = kind_of(value);
    if !SIGNALS.contains(&kind.as_str()) {
        let unit =
            format!("{unit}, or rows (time, value), or a SmoothStep, Table, Spline or Sines");
        return finite(value, name, &unit).map(Signal::Constant);
    }
    let read = Reader::new(value, name, &SIGNALS)?;
    let rows = || {
        let (given, name) = (read.get("rows")?, read.name("rows"));
        match given.cast::<PyTuple>() {
            Ok(given) => rows(given, &name, axis, unit),
            Err(_) => Err(refuse(&name, &given, "must be rows (time, value)")),
        }
    };
    let made = match kind.as_str() {
        "SmoothStep" => Signal::SmoothStep {
            start: read.number("start", "s")?,
            end: read.number("end", "s")?,
            from: read.number("before", unit)?,
            to: read.number("after", unit)?,
        },
        "Table" => Signal::Table(Table::new("Table.rows", unit, &rows()?)?),
        "Spline" => Signal::Spline(Spline::new("Spline.rows", unit, &rows()?)?),
        _ => Signal::Sines {
            offset: read.number("offset", unit)?,
            terms: terms(&read.get("terms")?)?,
        },
    };
    made.validate(&kind)?;
    Ok(made)
}

/// Read sines (amplitude, angular frequency, phase).
fn terms(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    value.extract().map_err(|_| {
        let expected =
            "must be rows of three numbers (amplitude, angular frequency [rad/s], phase [rad])";
        refuse("Sines.terms", value, expected)
    })
}

/// Read values against `axis`, a name and a unit: a number, a tuple of rows (axis, value), or a `Table`.
pub(crate) fn table(
    value: &Bound<'_, PyAny>,
    name: &str,
    axis: (&str, &str),
    unit: &str,
) -> PyResult<Table> {
    let given = if kind_of(value) == "Table" {
        value.getattr("rows")?
    } else {
        value.clone()
    };
    let rows = if let Ok(given) = given.cast::<PyTuple>() {
        rows(given, name, axis, unit)?
    } else {
        let forms = format!("{unit}, or rows ({}, value), or a Table", axis.0);
        vec![(0.0, finite(&given, name, &forms)?)]
    };
    Ok(Table::against(name, axis, unit, &rows)?)
}

fn rows(
    given: &Bound<'_, PyTuple>,
    name: &str,
    axis: (&str, &str),
    unit: &str,
) -> PyResult<Vec<(f64, f64)>> {
    let row = |row: Bound<'_, PyAny>| {
        let Ok([argument, value]) = row.extract::<[Bound<'_, PyAny>; 2]>() else {
            let expected = format!(
                "each row must be ({}, value): expected rows of two numbers",
                axis.0
            );
            return Err(refuse(name, &row, &expected));
        };
        Ok((
            number(&argument, &format!("{name} ({})", axis.0), axis.1)?,
            number(&value, &format!("{name} (value)"), unit)?,
        ))
    };
    given.iter().map(row).collect()
}

/// Return class names as alternatives: `a Coulomb or a LuGre`.
fn with_articles(kinds: &[&str]) -> String {
    let article = |kind: &str| {
        if kind.starts_with(['A', 'E', 'I', 'O', 'U']) {
            "an"
        } else {
            "a"
        }
    };
    let named: Vec<String> = kinds
        .iter()
        .map(|kind| format!("{} {kind}", article(kind)))
        .collect();
    named.join(" or ")
}

/// Return the name of an object's class.
///
/// Python's `str`, which `Display` calls, looks for signals: a Ctrl-C there would take the name.
pub(crate) fn kind_of(object: &Bound<'_, PyAny>) -> String {
    object.get_type().name().map_or_else(
        |_| String::new(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// Read a finite number.
pub(crate) fn finite(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<f64> {
    let found = number(value, field, unit)?;
    check::finite(field, found, unit)?;
    Ok(found)
}

/// Read True or False.
pub(crate) fn truth(value: &Bound<'_, PyAny>, field: &str) -> PyResult<bool> {
    value
        .extract()
        .map_err(|_| refuse(field, value, "must be True or False"))
}

/// Read a nonnegative integer.
pub(crate) fn count(value: &Bound<'_, PyAny>, field: &str) -> PyResult<u32> {
    if !value.is_instance_of::<PyBool>()
        && let Ok(count) = value.extract::<u32>()
    {
        return Ok(count);
    }
    let too_large = value.is_instance_of::<PyInt>() && value.gt(u32::MAX).unwrap_or(false);
    let expected = if too_large {
        format!("must be at most {}", u32::MAX)
    } else {
        "must be a whole number, not negative".to_string()
    };
    Err(refuse(field, value, &expected))
}

/// Read the numbers of teeth of two sprockets.
pub(crate) fn two_teeth(value: &Bound<'_, PyAny>) -> PyResult<[u32; 2]> {
    let [least, most] = TEETH;
    if let Ok([first, second]) = value.extract::<[Bound<'_, PyAny>; 2]>()
        && let (Ok(first), Ok(second)) = (count(&first, "teeth"), count(&second, "teeth"))
        && [first, second].iter().all(|n| (least..=most).contains(n))
    {
        return Ok([first, second]);
    }
    let expected = format!("must be two whole numbers between {least} and {most}");
    Err(refuse("teeth", value, &expected))
}

/// Read a number, which may be infinite or NaN.
pub(crate) fn number(value: &Bound<'_, PyAny>, field: &str, unit: &str) -> PyResult<f64> {
    if !value.is_instance_of::<PyBool>()
        && !value.is_instance_of::<PyString>()
        && let Ok(number) = value.extract::<f64>()
    {
        return Ok(number);
    }
    let expected = if unit == "1" {
        "must be a number".to_string()
    } else {
        format!("must be a number in {unit}")
    };
    Err(refuse(field, value, &expected))
}

/// Return the error of a field with a value of a wrong type, or the interrupt heard meanwhile.
pub(crate) fn refuse(field: &str, value: &Bound<'_, PyAny>, expected: &str) -> PyErr {
    match shown(value) {
        Ok(shown) => Error::invalid(field, shown, expected).into(),
        Err(interrupt) => interrupt,
    }
}

/// Return the `repr` of a value, or its class where a user's `repr` raises an exception.
///
/// # Errors
///
/// `KeyboardInterrupt` and other exceptions that no program is to catch.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> PyResult<String> {
    match value.repr() {
        Ok(text) => Ok(text.to_string_lossy().into_owned()),
        Err(error) if error.is_instance_of::<PyException>(value.py()) => {
            Ok(format!("<{}>", kind_of(value)))
        }
        Err(interrupt) => Err(interrupt),
    }
}
