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

    /// Return the last row of a channel of real numbers, flat; `None` without rows.
    pub(crate) fn last_row(&self, name: &str) -> Option<&[f64]> {
        let values = self.real(name);
        values.get(values.len().checked_sub(self.channel(name)?.row_length())?..)
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

    /// Release the memory of rows that did not come, in a run that ended early.
    pub(crate) fn release_room(&mut self) {
        for channel in &mut self.channels {
            match &mut channel.values {
                Values::Real(values) => release_room(values),
                Values::Whole(values) => release_room(values),
            }
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

/// Release reserved memory that is larger than the values.
fn release_room<T>(values: &mut Vec<T>) {
    if values.len() < values.capacity() / 2 {
        values.shrink_to_fit();
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

impl<'a> Row<'a> {
    /// Append a row to the next channel, one of real numbers, and return it: all of it is to be written.
    pub(crate) fn next_real(&mut self) -> &'a mut [f64] {
        self.channels.next().map_or(&mut [], |channel| {
            let numbers = channel.row_length();
            match &mut channel.values {
                Values::Real(all) => appended(all, numbers),
                Values::Whole(_) => &mut [],
            }
        })
    }

    /// Append a row to the next channel, one of integers, and return it: all of it is to be written.
    pub(crate) fn next_whole(&mut self) -> &'a mut [i32] {
        self.channels.next().map_or(&mut [], |channel| {
            let numbers = channel.row_length();
            match &mut channel.values {
                Values::Whole(all) => appended(all, numbers),
                Values::Real(_) => &mut [],
            }
        })
    }

    pub(crate) fn real(&mut self, values: impl IntoIterator<Item = f64>) {
        for (place, value) in self.next_real().iter_mut().zip(values) {
            *place = value;
        }
    }

    /// Write a channel of vectors of N components.
    pub(crate) fn vectors<const N: usize>(&mut self, values: impl IntoIterator<Item = [f64; N]>) {
        let (places, _) = self.next_real().as_chunks_mut();
        for (place, value) in places.iter_mut().zip(values) {
            *place = value;
        }
    }

    pub(crate) fn whole(&mut self, values: impl IntoIterator<Item = i32>) {
        for (place, value) in self.next_whole().iter_mut().zip(values) {
            *place = value;
        }
    }

    /// Write a channel of these numbers.
    pub(crate) fn copy(&mut self, values: &[f64]) {
        copy(&mut self.channels, values);
    }

    /// End the interval of the peaks of a kind with the `forces` of this row, and write largest forces and impulses.
    pub(crate) fn close_peaks(&mut self, kind: usize, forces: &[f64]) {
        for values in self.peaks[kind].close(self.time, forces, self.first) {
            copy(&mut self.channels, values);
        }
        self.peaks[kind].begin_interval();
    }
}

/// Write the next of these channels.
fn copy(channels: &mut std::slice::IterMut<Channel>, values: &[f64]) {
    if let Some(Values::Real(all)) = channels.next().map(|channel| &mut channel.values) {
        all.extend_from_slice(values);
    }
}

/// Append `count` numbers and return them.
///
/// The row before is copied: `resize` writes number by number.
fn appended<T: Copy + Default>(all: &mut Vec<T>, count: usize) -> &mut [T] {
    let first = all.len();
    match first.checked_sub(count) {
        Some(before) => all.extend_from_within(before..),
        None => all.resize(count, T::default()),
    }
    &mut all[first..]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rows of a scalar, of pairs and of whole numbers; `extra` values of a fourth row.
    fn recording(extra: usize) -> Recording {
        let scalar = Channel {
            values: Values::Real(vec![0.5, 1.5, 2.5, 3.5][..3 + extra].to_vec()),
            ..Channel::real("scalar", &[])
        };
        let pairs = Channel {
            values: Values::Real((0..6 + extra).map(|i| i as f64).collect()),
            ..Channel::real("pairs", &[2])
        };
        let whole = Channel {
            values: Values::Whole(vec![7, 8, 9, 10][..3 + extra].to_vec()),
            ..Channel::whole("whole", &[])
        };
        Recording {
            time: vec![0.1, 0.2, 0.3],
            channels: vec![scalar, pairs, whole],
        }
    }

    #[test]
    fn channels_are_found_by_name_and_by_kind_of_number() {
        let recording = recording(0);
        assert_eq!(recording.channel("pairs").unwrap().row_length(), 2);
        assert_eq!(recording.channel("scalar").unwrap().row_length(), 1);
        assert_eq!(recording.channel("none"), None);
        assert_eq!(recording.real("scalar"), [0.5, 1.5, 2.5]);
        assert_eq!(recording.whole("whole"), [7, 8, 9]);
        for (real, whole) in [("whole", "scalar"), ("none", "none")] {
            assert!(recording.real(real).is_empty() && recording.whole(whole).is_empty());
        }
        assert_eq!(Channel::real("blocks", &[2, 3]).row_length(), 6);
    }

    #[test]
    fn first_rows_are_taken_from_all_channels() {
        let mut rest = recording(0);
        let taken = rest.take_front(2);
        assert_eq!(taken.time, [0.1, 0.2]);
        assert_eq!(taken.real("scalar"), [0.5, 1.5]);
        assert_eq!(taken.real("pairs"), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(taken.whole("whole"), [7, 8]);
        assert_eq!(rest.time, [0.3]);
        assert_eq!(rest.real("pairs"), [4.0, 5.0]);
        assert_eq!(rest.whole("whole"), [9]);
        // More rows than there are: all of them.
        assert_eq!(rest.take_front(5).real("scalar"), [2.5]);
        assert!(rest.time.is_empty() && rest.real("pairs").is_empty());
    }

    #[test]
    fn values_of_an_incomplete_row_are_discarded() {
        let mut incomplete = recording(1);
        incomplete.truncate_to_whole_rows();
        assert_eq!(incomplete, recording(0));
    }

    #[test]
    fn a_row_is_written_in_the_order_of_its_channels_with_its_peaks_closed() {
        let mut channels = vec![
            Channel::real("place", &[2]),
            Channel::real("pairs", &[2, 2]),
            Channel::real("copy", &[3]),
            Channel::real("filled", &[2]),
            Channel::whole("region", &[1]),
            Channel::real("largest force", &[1]),
            Channel::real("impulse", &[1]),
        ];
        let mut peaks = [Peaks::new(1, 0.0)];
        for (time, force) in [(0.0, 2.0), (1.0, 4.0), (3.0, 1.0)] {
            let mut row = Row {
                channels: channels.iter_mut(),
                peaks: &mut peaks,
                time,
                first: time == 0.0,
            };
            row.real([time, -time]);
            row.vectors([[time, 1.0], [2.0, -time]]);
            row.copy(&[time, 2.0, 3.0]);
            row.next_real().fill(time);
            row.whole([5]);
            row.close_peaks(0, &[force]);
        }
        let recording = Recording {
            time: vec![0.0, 1.0, 3.0],
            channels,
        };
        assert_eq!(recording.real("place"), [0.0, 0.0, 1.0, -1.0, 3.0, -3.0]);
        let [pairs, copy] = ["pairs", "copy"].map(|name| recording.real(name));
        assert_eq!(pairs[..4], [0.0, 1.0, 2.0, -0.0]);
        assert_eq!(pairs[4..], [1.0, 1.0, 2.0, -1.0, 3.0, 1.0, 2.0, -3.0]);
        assert_eq!(copy, [0.0, 2.0, 3.0, 1.0, 2.0, 3.0, 3.0, 2.0, 3.0]);
        assert_eq!(recording.real("filled"), [0.0, 0.0, 1.0, 1.0, 3.0, 3.0]);
        assert_eq!(recording.whole("region"), [5, 5, 5]);
        // Trapezoidal rule: 1 s between 2 N and 4 N, then 2 s between 4 N and 1 N.
        assert_eq!(recording.real("largest force"), [2.0, 4.0, 4.0]);
        assert_eq!(recording.real("impulse"), [0.0, 3.0, 5.0]);
    }
}
