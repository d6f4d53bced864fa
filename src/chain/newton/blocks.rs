//! 2x2 blocks of eight hinges in the lanes of one or several SIMD vectors.

use crate::math::simd::{Lanes, Mask, Pack8, Vectors, WIDTH, parts, read, rotated};

/// One SIMD vector of symmetric 2x2 blocks: xx, yy, xy.
#[derive(Clone, Copy)]
pub(super) struct Symmetric<S: Vectors>(pub(super) [Lanes<S>; 3]);

/// One SIMD vector of 2x2 blocks in row-major order: xx, xy, yx, yy.
#[derive(Clone, Copy)]
pub(super) struct Block<S: Vectors>(pub(super) [Lanes<S>; 4]);

/// One SIMD vector of pairs x, y.
#[derive(Clone, Copy)]
pub(super) struct Vector<S: Vectors>(pub(super) [Lanes<S>; 2]);

/// Type composed of `N` SIMD vectors.
pub(super) trait Registers<S: Vectors, const N: usize>: Copy {
    /// Return the SIMD vectors.
    fn registers(self) -> [Lanes<S>; N];
    /// Compose from SIMD vectors.
    fn of_registers(registers: [Lanes<S>; N]) -> Self;

    /// Return self + other.
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let mut sum = self.registers();
        for (entry, other) in sum.iter_mut().zip(other.registers()) {
            *entry = *entry + other;
        }
        Self::of_registers(sum)
    }

    /// Return self - other.
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        let mut rest = self.registers();
        for (entry, other) in rest.iter_mut().zip(other.registers()) {
            *entry = *entry - other;
        }
        Self::of_registers(rest)
    }
}

macro_rules! registers {
    ($name:ident, $count:literal) => {
        impl<S: Vectors> Registers<S, $count> for $name<S> {
            #[inline(always)]
            fn registers(self) -> [Lanes<S>; $count] {
                self.0
            }
            #[inline(always)]
            fn of_registers(registers: [Lanes<S>; $count]) -> Self {
                Self(registers)
            }
        }

        impl<S: Vectors> $name<S> {
            /// Read vector `part` of these packs.
            #[inline(always)]
            pub(super) fn read(simd: S, packs8: &[Pack8<S::Number>; $count], part: usize) -> Self {
                Self(read(simd, packs8, part))
            }

            /// Return zero in all entries.
            #[inline(always)]
            pub(super) fn zero(simd: S) -> Self {
                Self([Lanes::splat(simd, 0.0); $count])
            }
        }
    };
}

registers!(Symmetric, 3);
registers!(Block, 4);
registers!(Vector, 2);

/// Return the eight numbers rotated to the right: lane k holds the value of lane k - `distance`, cyclically.
#[inline(always)]
pub(super) fn from_left<S: Vectors, T: Registers<S, N>, const N: usize>(
    simd: S,
    pack8: [T; WIDTH],
    distance: usize,
) -> [T; WIDTH] {
    from_right(simd, pack8, WIDTH - distance)
}

/// Return the eight numbers rotated to the left: lane k holds the value of lane k + `distance`, cyclically.
#[inline(always)]
pub(super) fn from_right<S: Vectors, T: Registers<S, N>, const N: usize>(
    simd: S,
    pack8: [T; WIDTH],
    distance: usize,
) -> [T; WIDTH] {
    let mut turned = pack8;
    let mut values = [pack8[0].registers(); WIDTH];
    for part in parts::<S>() {
        values[part] = pack8[part].registers();
    }
    for register in 0..N {
        let mut numbers = [values[0][register]; WIDTH];
        for part in parts::<S>() {
            numbers[part] = values[part][register];
        }
        let numbers = rotated(simd, numbers, distance);
        for part in parts::<S>() {
            values[part][register] = numbers[part];
        }
    }
    for part in parts::<S>() {
        turned[part] = T::of_registers(values[part]);
    }
    turned
}

impl<S: Vectors> Symmetric<S> {
    /// Return the inverse [d -b; -b a]/(a d - b²); set `irregular` where a block is not positive definite.
    #[inline(always)]
    pub(super) fn inverse(&self, irregular: &mut Mask<S>) -> Self {
        let [a, d, b] = self.0;
        let determinant = a.mul_add(d, -(b * b));
        let over = a.constant(1.0) / determinant;
        let zero = a.constant(0.0);
        // Comparisons with NaN are false: a block with NaN is irregular.
        let regular = determinant
            .greater(zero)
            .and(over.greater(zero))
            .and(a.greater(zero));
        *irregular = irregular.or(regular.not());
        Self([d * over, a * over, -(b * over)])
    }

    /// Return self m.
    #[inline(always)]
    pub(super) fn times_block(&self, m: &Block<S>) -> Block<S> {
        let ([a, d, b], [xx, xy, yx, yy]) = (self.0, m.0);
        Block([
            a.mul_add(xx, b * yx),
            a.mul_add(xy, b * yy),
            b.mul_add(xx, d * yx),
            b.mul_add(xy, d * yy),
        ])
    }

    /// Return self mᵀ.
    #[inline(always)]
    pub(super) fn times_transposed(&self, m: &Block<S>) -> Block<S> {
        self.times_block(&m.transposed())
    }

    /// Return self v.
    #[inline(always)]
    pub(super) fn of(&self, v: &Vector<S>) -> Vector<S> {
        let ([a, d, b], [x, y]) = (self.0, v.0);
        Vector([a.mul_add(x, b * y), b.mul_add(x, d * y)])
    }

    /// Return self m self.
    #[inline(always)]
    pub(super) fn between(&self, m: &Self) -> Self {
        let [a, d, b] = self.0;
        let own = Block([a, b, b, d]);
        own.transposed_times(&m.times_block(&own))
    }

    /// Subtract the product left right, which is symmetric.
    #[inline(always)]
    pub(super) fn sub_product(&mut self, left: &Block<S>, right: &Block<S>) {
        let ([a, b, c, d], [xx, xy, yx, yy]) = (left.0, right.0);
        let [first, last, beside] = self.0;
        self.0 = [
            a.negate_mul_add(xx, b.negate_mul_add(yx, first)),
            c.negate_mul_add(xy, d.negate_mul_add(yy, last)),
            a.negate_mul_add(xy, b.negate_mul_add(yy, beside)),
        ];
    }

    /// Add the product leftᵀ right, which is symmetric.
    #[inline(always)]
    pub(super) fn add(&mut self, left: &Block<S>, right: &Block<S>) {
        let ([a, b, c, d], [xx, xy, yx, yy]) = (left.0, right.0);
        let [first, last, beside] = self.0;
        self.0 = [
            a.mul_add(xx, c.mul_add(yx, first)),
            b.mul_add(xy, d.mul_add(yy, last)),
            a.mul_add(xy, c.mul_add(yy, beside)),
        ];
    }
}

impl<S: Vectors> Block<S> {
    /// Return selfᵀ.
    #[inline(always)]
    pub(super) fn transposed(&self) -> Self {
        let [xx, xy, yx, yy] = self.0;
        Self([xx, yx, xy, yy])
    }

    /// Return -self.
    #[inline(always)]
    pub(super) fn negated(&self) -> Self {
        let [xx, xy, yx, yy] = self.0;
        Self([-xx, -xy, -yx, -yy])
    }

    /// Return self other.
    #[inline(always)]
    pub(super) fn times(&self, other: &Self) -> Self {
        let ([a, b, c, d], [xx, xy, yx, yy]) = (self.0, other.0);
        Self([
            a.mul_add(xx, b * yx),
            a.mul_add(xy, b * yy),
            c.mul_add(xx, d * yx),
            c.mul_add(xy, d * yy),
        ])
    }

    /// Return self other for a symmetric `other`.
    #[inline(always)]
    pub(super) fn times_symmetric(&self, other: &Symmetric<S>) -> Self {
        let [a, d, b] = other.0;
        self.times(&Self([a, b, b, d]))
    }

    /// Return selfᵀ other, which is symmetric.
    #[inline(always)]
    pub(super) fn transposed_times(&self, other: &Self) -> Symmetric<S> {
        let ([a, b, c, d], [xx, xy, yx, yy]) = (self.0, other.0);
        Symmetric([
            a.mul_add(xx, c * yx),
            b.mul_add(xy, d * yy),
            a.mul_add(xy, c * yy),
        ])
    }

    /// Subtract the product left right.
    #[inline(always)]
    pub(super) fn sub_product(&mut self, left: &Self, right: &Self) {
        let ([a, b, c, d], [xx, xy, yx, yy]) = (left.0, right.0);
        let own = self.0;
        self.0 = [
            a.negate_mul_add(xx, b.negate_mul_add(yx, own[0])),
            a.negate_mul_add(xy, b.negate_mul_add(yy, own[1])),
            c.negate_mul_add(xx, d.negate_mul_add(yx, own[2])),
            c.negate_mul_add(xy, d.negate_mul_add(yy, own[3])),
        ];
    }

    /// Return from - self v.
    #[inline(always)]
    pub(super) fn less(&self, from: &Vector<S>, v: &Vector<S>) -> Vector<S> {
        let ([xx, xy, yx, yy], [x, y], [fx, fy]) = (self.0, v.0, from.0);
        Vector([
            xx.negate_mul_add(x, xy.negate_mul_add(y, fx)),
            yx.negate_mul_add(x, yy.negate_mul_add(y, fy)),
        ])
    }

    /// Return from - selfᵀ v.
    #[inline(always)]
    pub(super) fn transposed_less(&self, from: &Vector<S>, v: &Vector<S>) -> Vector<S> {
        self.transposed().less(from, v)
    }

    /// Return selfᵀ v.
    #[inline(always)]
    pub(super) fn transposed_of(&self, v: &Vector<S>) -> Vector<S> {
        let ([xx, xy, yx, yy], [x, y]) = (self.0, v.0);
        Vector([xx.mul_add(x, yx * y), xy.mul_add(x, yy * y)])
    }
}
