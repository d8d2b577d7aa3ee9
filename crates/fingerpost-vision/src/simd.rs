//! Which of a kernel's code paths runs.
//!
//! A kernel is one piece of plain Rust, compiled once for every instruction set by `simd_kernel!` and, where a compiler
//! does not find the fast way by itself, a hand-written twin of it. The processor is asked once, at run time.
//!
//! Every path gives the same bytes. Integers do so by nature; floating-point kernels do because none of them fuses a
//! product with a sum, and because sums that run over many pixels are kept in a fixed number of lanes that does not depend
//! on the path.

use std::sync::atomic::{AtomicU8, Ordering};

/// Instruction sets that kernels are compiled for, the least demanding first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum InstructionSet {
    /// What every machine of the target architecture has.
    Portable,
    /// x86-64 with AVX2, BMI1, BMI2, LZCNT and POPCNT: Intel since 2013, AMD since 2015.
    Avx2,
    /// x86-64 with AVX-512 F, BW, DQ, VL, VBMI and VNNI besides: Intel since 2019, AMD since 2022.
    Avx512,
}

impl InstructionSet {
    /// All of them, the least demanding first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];
}

/// A code path that this processor can run.
///
/// A value exists only where the processor has the instruction set: this is what makes calls into code that was compiled
/// for it sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CodePath(InstructionSet);

/// The most demanding set that may be used, as an index in [`InstructionSet::ALL`].
static MOST: AtomicU8 = AtomicU8::new(InstructionSet::ALL.len() as u8 - 1);

impl CodePath {
    /// The path that runs on any machine.
    pub const PORTABLE: Self = Self(InstructionSet::Portable);

    /// The fastest path of this processor, or a lesser one where [`CodePath::limit`] was called.
    #[must_use]
    pub fn fastest() -> Self {
        let most = usize::from(MOST.load(Ordering::Relaxed));
        let allowed = &InstructionSet::ALL[..=most.min(InstructionSet::ALL.len() - 1)];
        allowed.iter().rev().find_map(|&set| Self::with(set)).unwrap_or(Self::PORTABLE)
    }

    /// The path with `set`, or `None` where this processor does not have it.
    #[must_use]
    pub fn with(set: InstructionSet) -> Option<Self> {
        has(set).then_some(Self(set))
    }

    /// Every path of this processor, the portable one first: what tests compare.
    pub fn available() -> impl Iterator<Item = Self> {
        InstructionSet::ALL.into_iter().filter_map(Self::with)
    }

    /// Lets all kernels of the program use `most` at the most, from now on. Results do not depend on it.
    pub fn limit(most: InstructionSet) {
        MOST.store(most as u8, Ordering::Relaxed);
    }

    /// The instruction set of this path.
    #[must_use]
    pub const fn instruction_set(self) -> InstructionSet {
        self.0
    }
}

#[cfg(target_arch = "x86_64")]
fn has(set: InstructionSet) -> bool {
    // The features are those that `simd_kernel!` compiles for. Each question is answered from memory after the first.
    let avx2 = || {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    };
    let avx512 = || {
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512vbmi")
            && is_x86_feature_detected!("avx512vnni")
    };
    match set {
        InstructionSet::Portable => true,
        InstructionSet::Avx2 => avx2(),
        InstructionSet::Avx512 => avx2() && avx512(),
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn has(set: InstructionSet) -> bool {
    set == InstructionSet::Portable
}

/// Compiles a function once for every [`InstructionSet`]. The function gets a first parameter, the [`CodePath`] that is to
/// run; its body is plain Rust, which the compiler turns into vectors as wide as the instruction set has.
macro_rules! simd_kernel {
    ($(#[$attribute:meta])* $visibility:vis fn $name:ident$(<$(const $constant:ident: $of:ty),+>)?(
        $($parameter:ident: $type:ty),* $(,)?
    ) $(-> $result:ty)? $body:block) => {
        $(#[$attribute])*
        #[allow(clippy::too_many_arguments, reason = "a kernel's arrays are its arguments")]
        $visibility fn $name$(<$(const $constant: $of),+>)?(
            path: $crate::simd::CodePath, $($parameter: $type),*
        ) $(-> $result)? {
            #[inline(always)]
            #[allow(clippy::too_many_arguments, reason = "a kernel's arrays are its arguments")]
            fn portable$(<$(const $constant: $of),+>)?($($parameter: $type),*) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            #[allow(clippy::too_many_arguments, reason = "a kernel's arrays are its arguments")]
            fn avx2$(<$(const $constant: $of),+>)?($($parameter: $type),*) $(-> $result)? {
                portable$(::<$($constant),+>)?($($parameter),*)
            }

            #[cfg(target_arch = "x86_64")]
            #[target_feature(
                enable = "avx512f,avx512bw,avx512dq,avx512vl,avx512vbmi,avx512vnni,avx2,bmi1,bmi2,lzcnt,popcnt"
            )]
            #[allow(clippy::too_many_arguments, reason = "a kernel's arrays are its arguments")]
            fn avx512$(<$(const $constant: $of),+>)?($($parameter: $type),*) $(-> $result)? {
                portable$(::<$($constant),+>)?($($parameter),*)
            }

            match path.instruction_set() {
                // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its
                // features.
                #[cfg(target_arch = "x86_64")]
                #[allow(unsafe_code)]
                $crate::simd::InstructionSet::Avx2 => unsafe { avx2$(::<$($constant),+>)?($($parameter),*) },
                // SAFETY: as above.
                #[cfg(target_arch = "x86_64")]
                #[allow(unsafe_code)]
                $crate::simd::InstructionSet::Avx512 => unsafe {
                    avx512$(::<$($constant),+>)?($($parameter),*)
                },
                _ => portable$(::<$($constant),+>)?($($parameter),*),
            }
        }
    };
}
pub(crate) use simd_kernel;

#[cfg(test)]
mod tests {
    use super::*;

    simd_kernel! {
        /// A sum that is different in every bit when a path goes wrong.
        fn checksum<const FACTOR: u32>(values: &[u32]) -> u32 {
            values.iter().fold(0, |sum, value| sum ^ value.wrapping_mul(FACTOR))
        }
    }

    #[test]
    fn every_path_of_this_machine_runs_and_the_portable_one_is_among_them() {
        let values: Vec<u32> = (0..1003).map(|i: u32| i.wrapping_mul(2_654_435_761)).collect();
        let expected = values.iter().fold(0, |sum, value| sum ^ value.wrapping_mul(7));
        let paths: Vec<CodePath> = CodePath::available().collect();
        assert_eq!(paths[0], CodePath::PORTABLE);
        for path in paths {
            assert_eq!(checksum::<7>(path, &values), expected, "{path:?}");
        }
        assert!(CodePath::available().any(|path| path == CodePath::fastest()));
    }
}
