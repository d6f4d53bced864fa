//! Transposition of vectors: rows become columns in registers, if the machine has the instructions.

#[cfg(target_arch = "x86_64")]
use std::any::Any;

#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

#[cfg(target_arch = "x86_64")]
use super::precision::Single;
use super::{Lanes, Vectors, WIDTH};

/// Return the transpose: lane i of vector j becomes lane j of vector i, for as many vectors as lanes. Further vectors remain unchanged.
#[inline(always)]
pub(crate) fn transposed<S: Vectors>(simd: S, rows: [Lanes<S>; WIDTH]) -> [Lanes<S>; WIDTH] {
    #[cfg(target_arch = "x86_64")]
    {
        let any: &dyn Any = &simd;
        if let Some(&instructions) = any.downcast_ref::<V4>() {
            return eight(simd, instructions, &rows);
        }
        if let Some(&instructions) = any.downcast_ref::<V3>() {
            return four(simd, instructions, rows);
        }
        if let Some(&instructions) = any.downcast_ref::<Single<V3>>() {
            return eight_singles(simd, instructions.instructions(), &rows);
        }
    }
    let mut columns = rows;
    let mut numbers = [[S::Number::default(); WIDTH]; WIDTH];
    for (i, row) in rows.iter().enumerate().take(S::LANES) {
        let row = [row.values()];
        let row: &[S::Number] = bytemuck::cast_slice(&row);
        for (numbers, &number) in numbers.iter_mut().zip(row) {
            numbers[i] = number;
        }
    }
    for (column, numbers) in columns.iter_mut().zip(&numbers).take(S::LANES) {
        *column = super::load(simd, &super::vectors::<S>(numbers, 1)[0]);
    }
    columns
}

/// Transpose pairs of rows, then pairs of pairs, then both halves.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn eight_singles<S: Vectors>(
    simd: S,
    instructions: V3,
    rows: &[Lanes<S>; WIDTH],
) -> [Lanes<S>; WIDTH] {
    use std::arch::x86_64::{__m256, __m256d};
    /// Selects the first half of one vector, then of another.
    const FIRST: i32 = 0b0010_0000;
    const SECOND: i32 = 0b0011_0001;

    let avx = instructions.avx;
    let row = |i: usize| bytemuck::cast::<S::Vector, __m256>(rows[i].values());
    let pairs = |of: __m256| bytemuck::cast::<__m256, __m256d>(of);
    let even = |i: usize| pairs(avx._mm256_unpacklo_ps(row(i), row(i + 1)));
    let odd = |i: usize| pairs(avx._mm256_unpackhi_ps(row(i), row(i + 1)));
    // Columns 0 and 4, 1 and 5, 2 and 6, 3 and 7, each as rows 0 to 3 and rows 4 to 7.
    let (first, last) = (
        [even(0), even(2), even(4), even(6)],
        [odd(0), odd(2), odd(4), odd(6)],
    );
    let low = |a, b| avx._mm256_unpacklo_pd(a, b);
    let high = |a, b| avx._mm256_unpackhi_pd(a, b);
    let halves = [
        [low(first[0], first[1]), low(first[2], first[3])],
        [high(first[0], first[1]), high(first[2], first[3])],
        [low(last[0], last[1]), low(last[2], last[3])],
        [high(last[0], last[1]), high(last[2], last[3])],
    ];
    let column = |of: __m256d| Lanes::new(simd, bytemuck::cast::<__m256d, S::Vector>(of));
    let front = |i: usize| column(avx._mm256_permute2f128_pd::<FIRST>(halves[i][0], halves[i][1]));
    let rear = |i: usize| column(avx._mm256_permute2f128_pd::<SECOND>(halves[i][0], halves[i][1]));
    [
        front(0),
        front(1),
        front(2),
        front(3),
        rear(0),
        rear(1),
        rear(2),
        rear(3),
    ]
}

/// Transpose pairs of rows, then pairs of pairs, then both halves.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn eight<S: Vectors>(simd: S, instructions: V4, rows: &[Lanes<S>; WIDTH]) -> [Lanes<S>; WIDTH] {
    use std::arch::x86_64::__m512d;
    /// Selects the first and third quarter of one vector, then of another.
    const FIRST_AND_THIRD: i32 = 0b10_00_10_00;
    const SECOND_AND_FOURTH: i32 = 0b11_01_11_01;

    let avx = instructions.avx512f;
    let row = |i: usize| bytemuck::cast::<S::Vector, __m512d>(rows[i].values());
    let even = |i: usize| avx._mm512_unpacklo_pd(row(i), row(i + 1));
    let odd = |i: usize| avx._mm512_unpackhi_pd(row(i), row(i + 1));
    let low = |a, b| avx._mm512_shuffle_f64x2::<FIRST_AND_THIRD>(a, b);
    let high = |a, b| avx._mm512_shuffle_f64x2::<SECOND_AND_FOURTH>(a, b);
    let even = [even(0), even(2), even(4), even(6)];
    let odd = [odd(0), odd(2), odd(4), odd(6)];
    // Columns 0 and 4, 1 and 5, 2 and 6, 3 and 7, each as rows 0 to 3 and rows 4 to 7.
    let halves = [
        [low(even[0], even[1]), low(even[2], even[3])],
        [low(odd[0], odd[1]), low(odd[2], odd[3])],
        [high(even[0], even[1]), high(even[2], even[3])],
        [high(odd[0], odd[1]), high(odd[2], odd[3])],
    ];
    let column = |of| Lanes::new(simd, bytemuck::cast::<__m512d, S::Vector>(of));
    let first = |i: usize| column(low(halves[i][0], halves[i][1]));
    let last = |i: usize| column(high(halves[i][0], halves[i][1]));
    [
        first(0),
        first(1),
        first(2),
        first(3),
        last(0),
        last(1),
        last(2),
        last(3),
    ]
}

/// Transpose pairs of rows, then both halves.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn four<S: Vectors>(simd: S, instructions: V3, rows: [Lanes<S>; WIDTH]) -> [Lanes<S>; WIDTH] {
    use std::arch::x86_64::__m256d;
    /// Selects the first half of one vector, then of another.
    const FIRST: i32 = 0b0010_0000;
    const SECOND: i32 = 0b0011_0001;

    let avx = instructions.avx;
    let row = |i: usize| bytemuck::cast::<S::Vector, __m256d>(rows[i].values());
    let even = [
        avx._mm256_unpacklo_pd(row(0), row(1)),
        avx._mm256_unpacklo_pd(row(2), row(3)),
    ];
    let odd = [
        avx._mm256_unpackhi_pd(row(0), row(1)),
        avx._mm256_unpackhi_pd(row(2), row(3)),
    ];
    let column = |of| Lanes::new(simd, bytemuck::cast::<__m256d, S::Vector>(of));
    let mut columns = rows;
    columns[0] = column(avx._mm256_permute2f128_pd::<FIRST>(even[0], even[1]));
    columns[1] = column(avx._mm256_permute2f128_pd::<FIRST>(odd[0], odd[1]));
    columns[2] = column(avx._mm256_permute2f128_pd::<SECOND>(even[0], even[1]));
    columns[3] = column(avx._mm256_permute2f128_pd::<SECOND>(odd[0], odd[1]));
    columns
}

#[cfg(test)]
mod tests {
    use pulp::{Simd, WithSimd};

    use super::*;
    use crate::math::simd::{InstructionSet, Number, load, vectors, vectors_mut};

    struct Transpose<'a, T>(&'a [[T; WIDTH]; WIDTH], &'a mut [[T; WIDTH]; WIDTH]);

    impl<T: Number> Transpose<'_, T> {
        #[inline(always)]
        fn run<S: Vectors<Number = T>>(self, simd: S) -> usize {
            let mut rows = [Lanes::splat(simd, 0.0); WIDTH];
            for (row, numbers) in rows.iter_mut().zip(self.0) {
                *row = load(simd, &vectors::<S>(numbers, 1)[0]);
            }
            for (numbers, column) in self.1.iter_mut().zip(transposed(simd, rows)) {
                vectors_mut::<S>(numbers, 1)[0] = column.values();
            }
            S::LANES
        }
    }

    impl<T: Number> WithSimd for Transpose<'_, T> {
        type Output = usize;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> usize {
            self.run(T::vectors(simd))
        }
    }

    fn assert_rows_become_columns<T: Number + PartialEq>() {
        let number = |i: usize, j: usize| T::nearest((10 * i + j) as f64);
        let rows: [[T; WIDTH]; WIDTH] =
            std::array::from_fn(|i| std::array::from_fn(|j| number(i, j)));
        for set in InstructionSet::available() {
            let mut columns = [[T::nearest(-1.0); WIDTH]; WIDTH];
            let lanes = T::run(set, Transpose(&rows, &mut columns));
            for (i, column) in columns.iter().enumerate().take(lanes) {
                for (j, &number) in column.iter().enumerate().take(lanes) {
                    assert_eq!(number, rows[j][i], "{}", set.name());
                }
            }
        }
    }

    #[test]
    fn rows_become_columns_at_every_width_in_both_precisions() {
        assert_rows_become_columns::<f64>();
        assert_rows_become_columns::<f32>();
    }
}
