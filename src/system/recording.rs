//! Recording of a run: one row of each channel at each report time.

use super::peaks::Peaks;

/// Values of one channel, row by row.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Real numbers.
    Real(Vec<f64>),
    /// Integers.
    Whole(Vec<i32>),
}

/// Recorded quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the channel.
    pub name: &'static str,
    /// Shape of one row; empty for a scalar.
    pub row_shape: Vec<usize>,
    /// All rows.
    pub values: Values,
}

impl Channel {
    /// Return a channel of real numbers without rows.
    #[must_use]
    pub fn real(name: &'static str, row_shape: &[usize]) -> Self {
        Self {
            name,
            row_shape: row_shape.to_vec(),
            values: Values::Real(Vec::new()),
        }
    }

    /// Return a channel of integers without rows.
    #[must_use]
    pub fn whole(name: &'static str, row_shape: &[usize]) -> Self {
        Self {
            values: Values::Whole(Vec::new()),
            ..Self::real(name, row_shape)
        }
    }

    /// Reserve memory for `rows`, as far as there is any.
    pub(crate) fn make_room(&mut self, rows: usize) {
        let numbers = rows * self.row_length();
        // Without memory the vector grows row by row, as far as it can.
        let _ = match &mut self.values {
            Values::Real(values) => values.try_reserve_exact(numbers),
            Values::Whole(values) => values.try_reserve_exact(numbers),
        };
    }

    /// Return the number of values per row.
    #[must_use]
    pub fn row_length(&self) -> usize {
        self.row_shape.iter().product()
    }
}

/// Recorded rows of all channels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Report times \[s\].
    pub time: Vec<f64>,
    /// Recorded channels.
    pub channels: Vec<Channel>,
}

impl Recording {
    /// Return the channel of this name.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Return all rows of a channel of real numbers, flat; empty if there is no such channel.
    #[must_use]
    pub fn real(&self, name: &str) -> &[f64] {
        match self.channel(name).map(|channel| &channel.values) {
            Some(Values::Real(values)) => values,
            _ => &[],
        }
    }

    /// Return all rows of a channel of integers, flat; empty if there is no such channel.
    #[must_use]
    pub fn whole(&self, name: &str) -> &[i32] {
        match self.channel(name).map(|channel| &channel.values) {
            Some(Values::Whole(values)) => values,
            _ => &[],
        }
    }

    /// Remove the first `count` rows, or all if there are fewer, and return them.
    pub(crate) fn take_front(&mut self, count: usize) -> Self {
        let count = count.min(self.time.len());
        let channels = self.channels.iter_mut().map(|channel| {
            let numbers = count * channel.row_length();
            Channel {
                name: channel.name,
                row_shape: channel.row_shape.clone(),
                values: match &mut channel.values {
                    Values::Real(values) => Values::Real(take_front(values, numbers)),
                    Values::Whole(values) => Values::Whole(take_front(values, numbers)),
                },
            }
        });
        Self {
            channels: channels.collect(),
            time: take_front(&mut self.time, count),
        }
    }

    /// Discard the values of an incomplete row.
    pub(crate) fn truncate_to_whole_rows(&mut self) {
        let rows = self.time.len();
        for channel in &mut self.channels {
            let numbers = rows * channel.row_length();
            match &mut channel.values {
                Values::Real(values) => values.truncate(numbers),
                Values::Whole(values) => values.truncate(numbers),
            }
        }
    }
}

/// Remove the first `count` values and return them.
///
/// `values` keeps its memory: pieces of a long run that each grow from nothing fragment the heap.
fn take_front<T>(values: &mut Vec<T>, count: usize) -> Vec<T> {
    values.drain(..count).collect()
}

/// Row under construction: its channels, in the order of their definition.
#[derive(Debug)]
pub struct Row<'a> {
    pub(crate) channels: std::slice::IterMut<'a, Channel>,
    pub(crate) peaks: &'a mut [Peaks],
    /// Time of the row \[s\].
    pub(crate) time: f64,
    /// True for the first row.
    pub(crate) first: bool,
}

impl Row<'_> {
    pub(crate) fn real(&mut self, values: impl IntoIterator<Item = f64>) {
        if let Some(Channel {
            values: Values::Real(all),
            ..
        }) = self.channels.next()
        {
            all.extend(values);
        }
    }

    pub(crate) fn whole(&mut self, values: impl IntoIterator<Item = i32>) {
        if let Some(Channel {
            values: Values::Whole(all),
            ..
        }) = self.channels.next()
        {
            all.extend(values);
        }
    }

    /// End the interval of the peaks of a kind with the `forces` of this row, and write largest forces and impulses.
    pub(crate) fn close_peaks(&mut self, kind: usize, forces: &[f64]) {
        for values in self.peaks[kind].close(self.time, forces, self.first) {
            if let Some(Channel {
                values: Values::Real(all),
                ..
            }) = self.channels.next()
            {
                all.extend(values);
            }
        }
        self.peaks[kind].begin_interval();
    }
}
