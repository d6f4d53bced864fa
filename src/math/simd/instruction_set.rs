//! Which instructions the kernels use.

use pulp::{Arch, WithSimd};

/// Numbers in a register of AVX2.
#[cfg(target_arch = "x86_64")]
const AVX2_NUMBERS: usize = 4;

/// An instruction set that this machine has.
#[derive(Debug, Clone, Copy)]
pub struct InstructionSet(Arch);

impl InstructionSet {
    /// The widest one here.
    #[must_use]
    pub fn detect() -> Self {
        Self::available()[0]
    }

    /// The one here that is best for arrays of `length` numbers: what fits in one register of AVX2 gains nothing from a wider one, which
    /// waits longer for numbers that were just stored one by one.
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

    /// All that this machine has, the widest first. The last one is the plain one, of one number at a time.
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

    /// The one of this name: "avx512", "avx2", "neon" or "plain"; `None` when this machine does not have it.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::available().into_iter().find(|set| set.name() == name)
    }

    /// Its name: "avx512", "avx2", "neon" or "plain".
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

    /// Whether products and sums are fused, with one rounding.
    #[must_use]
    pub fn has_fused_multiply_add(self) -> bool {
        !matches!(self.0, Arch::Scalar)
    }

    /// Runs a kernel with these instructions.
    #[inline(always)]
    pub(crate) fn run<Kernel: WithSimd>(self, kernel: Kernel) -> Kernel::Output {
        #[cfg(all(avx2_only, target_arch = "x86_64"))]
        return match self.0 {
            Arch::V3(v3) => pulp::Simd::vectorize(v3, kernel),
            _ => pulp::Simd::vectorize(pulp::Scalar::new(), kernel),
        };
        #[cfg(not(all(avx2_only, target_arch = "x86_64")))]
        self.0.dispatch(kernel)
    }
}

impl Default for InstructionSet {
    fn default() -> Self {
        Self::detect()
    }
}
