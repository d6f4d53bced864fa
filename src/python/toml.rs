//! TOML as Python values, with the position of each key and of each list item.

use pyo3::IntoPyObjectExt;
use pyo3::exceptions::{PyRecursionError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use toml_edit::{Array, ArrayOfTables, Document, Item, TableLike, Value};

/// Return the content of a TOML text, and line and column, from 1, of each key and item by its path: names, and indices from 0 in lists.
/// Dates and times are text.
#[pyfunction]
pub(super) fn read_toml<'py>(
    py: Python<'py>,
    text: &str,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let document = Document::parse(text).map_err(|error| refusal(text, &error))?;
    let mut reader = TomlReader {
        py,
        path: Vec::new(),
        starts: Vec::new(),
    };
    let content = reader.table(document.as_table())?;
    Ok((content, reader.places(text)?))
}

/// Return the error of an invalid TOML text, with its position.
fn refusal(text: &str, error: &toml_edit::TomlError) -> PyErr {
    let mut places = Places::of(text);
    let (line, column) = places.at(error.span().map_or(text.len(), |span| span.start));
    let message = error.message().replace('\n', "; ");
    let text = format!("{message}, at line {line}, column {column}");
    // Detects the nesting limit of the TOML reader by its message, because the error has no kind.
    if message.contains("recurs") {
        return PyRecursionError::new_err(text);
    }
    PyValueError::new_err(text)
}

/// Builder of Python values that records the first byte of each.
struct TomlReader<'py> {
    py: Python<'py>,
    path: Vec<Bound<'py, PyAny>>,
    starts: Vec<(usize, Bound<'py, PyTuple>)>,
}

impl<'py> TomlReader<'py> {
    fn table(&mut self, table: &dyn TableLike) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(self.py);
        for (name, item) in table.iter() {
            let start = table.key(name).and_then(toml_edit::Key::span);
            let value = self.below(name, start, |reader| reader.item(item))?;
            found.set_item(name, value)?;
        }
        Ok(found)
    }

    fn item(&mut self, item: &Item) -> PyResult<Bound<'py, PyAny>> {
        match item {
            Item::None => Ok(self.py.None().into_bound(self.py)),
            Item::Value(value) => self.value(value),
            Item::Table(table) => Ok(self.table(table)?.into_any()),
            Item::ArrayOfTables(tables) => self.tables(tables),
        }
    }

    fn value(&mut self, value: &Value) -> PyResult<Bound<'py, PyAny>> {
        match value {
            Value::String(text) => text.value().into_bound_py_any(self.py),
            Value::Integer(number) => number.value().into_bound_py_any(self.py),
            Value::Float(number) => number.value().into_bound_py_any(self.py),
            Value::Boolean(truth) => truth.value().into_bound_py_any(self.py),
            Value::Datetime(time) => time.value().to_string().into_bound_py_any(self.py),
            Value::Array(array) => self.array(array),
            Value::InlineTable(table) => Ok(self.table(table)?.into_any()),
        }
    }

    fn array(&mut self, array: &Array) -> PyResult<Bound<'py, PyAny>> {
        let found = PyList::empty(self.py);
        for (place, value) in array.iter().enumerate() {
            found.append(self.below(place, value.span(), |reader| reader.value(value))?)?;
        }
        Ok(found.into_any())
    }

    fn tables(&mut self, tables: &ArrayOfTables) -> PyResult<Bound<'py, PyAny>> {
        let found = PyList::empty(self.py);
        for (place, table) in tables.iter().enumerate() {
            found.append(self.below(place, table.span(), |reader| reader.table(table))?)?;
        }
        Ok(found.into_any())
    }

    /// Read a value under `key`, whose text is at `span`.
    fn below<T>(
        &mut self,
        key: impl IntoPyObjectExt<'py>,
        span: Option<std::ops::Range<usize>>,
        read: impl FnOnce(&mut Self) -> PyResult<T>,
    ) -> PyResult<T> {
        self.path.push(key.into_bound_py_any(self.py)?);
        if let Some(span) = span {
            let path = PyTuple::new(self.py, &self.path)?;
            self.starts.push((span.start, path));
        }
        let value = read(self)?;
        self.path.pop();
        Ok(value)
    }

    /// Return line and column of each path.
    fn places(mut self, text: &str) -> PyResult<Bound<'py, PyDict>> {
        self.starts.sort_by_key(|(start, _)| *start);
        let found = PyDict::new(self.py);
        let mut places = Places::of(text);
        for (start, path) in self.starts {
            found.set_item(path, places.at(start))?;
        }
        Ok(found)
    }
}

/// Counter of lines and columns in a single pass over a text.
struct Places<'text> {
    text: &'text str,
    byte: usize,
    line: usize,
    column: usize,
}

impl<'text> Places<'text> {
    fn of(text: &'text str) -> Self {
        Self {
            text,
            byte: 0,
            line: 1,
            column: 1,
        }
    }

    /// Return line and column of a byte; bytes must be passed in ascending order.
    fn at(&mut self, byte: usize) -> (usize, usize) {
        for character in self.text.get(self.byte..byte).unwrap_or_default().chars() {
            (self.line, self.column) = match character {
                '\n' => (self.line + 1, 1),
                _ => (self.line, self.column + 1),
            };
        }
        self.byte = byte;
        (self.line, self.column)
    }
}
