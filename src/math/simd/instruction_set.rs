//! Instruction set of the kernels.

use pulp::{Arch, Simd, WithSimd};

/// Number of lanes of an AVX2 register.
#[cfg(target_arch = "x86_64")]
const AVX2_NUMBERS: usize = 4;

/// A kernel over arrays of one length that is compiled once for a single vector and once for more.
///
/// The code for one vector has no loop: it needs few registers and has none of those of the loop to save.
pub(crate) trait BlockKernel: Sized {
    /// Result.
    type Output;

    /// Return the length of the arrays without padding.
    fn length(&self) -> usize;

    /// Run for `blocks` vectors, a constant for one vector; to be inlined.
    fn with_blocks<S: Simd>(self, simd: S, blocks: usize) -> Self::Output;
}

/// A kernel of one vector.
struct OneBlock<Kernel>(Kernel);

/// A kernel of any number of vectors.
struct Blocks<Kernel>(Kernel);

impl<Kernel: BlockKernel> WithSimd for OneBlock<Kernel> {
    type Output = Kernel::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        self.0.with_blocks(simd, 1)
    }
}

impl<Kernel: BlockKernel> WithSimd for Blocks<Kernel> {
    type Output = Kernel::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        // Fewer instructions than `div_ceil`, which tests the remainder.
        let blocks = (self.0.length() + S::F64_LANES - 1) >> S::F64_LANES.trailing_zeros();
        self.0.with_blocks(simd, blocks)
    }
}

/// Run a kernel for one vector or for more.
#[inline(always)]
fn run_by_length<S: Simd, Kernel: BlockKernel>(simd: S, kernel: Kernel) -> Kernel::Output {
    if (1..=S::F64_LANES).contains(&kernel.length()) {
        simd.vectorize(OneBlock(kernel))
    } else {
        simd.vectorize(Blocks(kernel))
    }
}

/// Instruction set available on this machine.
#[derive(Debug, Clone, Copy)]
pub struct InstructionSet(Arch);

impl InstructionSet {
    /// Return the widest instruction set available.
    #[must_use]
    pub fn detect() -> Self {
        Self::available()[0]
    }

    /// Return the best available instruction set for arrays of `length` numbers. Arrays that fit into one AVX2 register gain nothing from
    /// wider registers, whose loads wait longer for numbers that were stored one by one.
    #[must_use]
    pub fn detect_for(length: usize) -> Self {
        #[cfg(target_arch = "x86_64")]
        if length <= AVX2_NUMBERS
            && let Some(v3) = pulp::x86::V3::try_new()
        {
            return Self(Arch::V3(v3));
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = length;
        Self::detect()
    }

    /// Return all available instruction sets, widest first; the last is the plain one, with a single lane.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut sets = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            #[cfg(not(avx2_only))]
            sets.extend(pulp::x86::V4::try_new().map(|v4| Self(Arch::V4(v4))));
            sets.extend(pulp::x86::V3::try_new().map(|v3| Self(Arch::V3(v3))));
        }
        #[cfg(target_arch = "aarch64")]
        sets.extend(pulp::aarch64::Neon::try_new().map(|neon| Self(Arch::Neon(neon))));
        sets.push(Self(Arch::Scalar));
        sets
    }

    /// Return the name: "avx512", "avx2", "neon" or "plain".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Arch::V4(_) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Arch::V3(_) => "avx2",
            #[cfg(target_arch = "aarch64")]
            Arch::Neon(_) => "neon",
            _ => "plain",
        }
    }

    /// Return whether products and sums are fused, with a single rounding.
    #[must_use]
    pub fn has_fused_multiply_add(self) -> bool {
        !matches!(self.0, Arch::Scalar)
    }

    /// Run a kernel with these instructions.
    #[inline(always)]
    pub(crate) fn run<Kernel: WithSimd>(self, kernel: Kernel) -> Kernel::Output {
        match self.0 {
            #[cfg(all(target_arch = "x86_64", not(avx2_only)))]
            Arch::V4(v4) => Simd::vectorize(v4, kernel),
            #[cfg(target_arch = "x86_64")]
            Arch::V3(v3) => Simd::vectorize(v3, kernel),
            #[cfg(target_arch = "aarch64")]
            Arch::Neon(neon) => Simd::vectorize(neon, kernel),
            _ => run_plain(kernel),
        }
    }

    /// Run a kernel that is compiled apart for a single vector.
    #[inline(always)]
    pub(crate) fn run_blocks<Kernel: BlockKernel>(self, kernel: Kernel) -> Kernel::Output {
        match self.0 {
            #[cfg(all(target_arch = "x86_64", not(avx2_only)))]
            Arch::V4(v4) => run_by_length(v4, kernel),
            #[cfg(target_arch = "x86_64")]
            Arch::V3(v3) => run_by_length(v3, kernel),
            #[cfg(target_arch = "aarch64")]
            Arch::Neon(neon) => run_by_length(neon, kernel),
            _ => run_plain(Blocks(kernel)),
        }
    }

    /// Run a kernel with vectors of at most 256 bits: they hold eight numbers of single precision.
    #[inline(always)]
    pub(crate) fn run_half_as_wide<Kernel: WithSimd>(self, kernel: Kernel) -> Kernel::Output {
        match self.0 {
            #[cfg(all(target_arch = "x86_64", not(avx2_only)))]
            Arch::V4(v4) => Simd::vectorize(*v4, kernel),
            #[cfg(target_arch = "x86_64")]
            Arch::V3(v3) => Simd::vectorize(v3, kernel),
            #[cfg(target_arch = "aarch64")]
            Arch::Neon(neon) => Simd::vectorize(neon, kernel),
            _ => run_plain(kernel),
        }
    }
}

/// Run a kernel with single lanes. It is not inlined: several callers share one copy, as vectorized kernels have.
#[inline(never)]
fn run_plain<Kernel: WithSimd>(kernel: Kernel) -> Kernel::Output {
    Simd::vectorize(pulp::Scalar::new(), kernel)
}

impl Default for InstructionSet {
    fn default() -> Self {
        Self::detect()
    }
}
