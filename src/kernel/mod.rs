//! The inner loops, over plain slices and numbers, and all `unsafe` of the crate.
//!
//! One run-time dispatch picks the instruction set; the scalar twin of each kernel defines its result, bit for bit.

pub mod band;
pub mod box_down;
pub mod cast;
pub mod lanes;
pub mod pages;
pub mod plane;
pub mod prefix;
pub mod range;
pub mod remap;
pub mod soft_codes;
pub mod spot;
pub mod taps;
pub mod window;

use crate::error::{Error, Result};
use std::cell::Cell;
use std::sync::OnceLock;

/// Instruction sets that kernels are written for, weakest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Isa {
    /// Plain Rust: the definition.
    Scalar,
    /// The base set of x86-64, and so what `Scalar` is compiled for there: the same code under the set's name.
    Sse2,
    /// aarch64, which always has it: lanes by hand, plain Rust elsewhere.
    Neon,
    /// x86-64 with AVX2.
    Avx2,
    /// x86-64 with AVX-512 F, BW, VL, DQ and VBMI.
    Avx512,
}

thread_local! {
    static FORCED: Cell<Option<Isa>> = const { Cell::new(None) };
}

impl Isa {
    /// All sets with the words that `MULTUM_SIMD` knows for them.
    pub const NAMES: [(&'static str, Self); 4] =
        [("scalar", Self::Scalar), ("sse2", Self::Sse2), ("avx2", Self::Avx2), ("avx512", Self::Avx512)];

    /// Whether this machine has the set.
    pub fn is_supported(self) -> bool {
        match self {
            Self::Scalar => true,
            Self::Sse2 => cfg!(target_arch = "x86_64"),
            Self::Neon => cfg!(target_arch = "aarch64"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vbmi")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The sets that this machine has, weakest first.
    pub fn available() -> Vec<Self> {
        Self::NAMES.iter().map(|(_, isa)| *isa).filter(|isa| isa.is_supported()).collect()
    }

    /// The set that the environment variable `MULTUM_SIMD` names, if it is there and not empty.
    ///
    /// # Errors
    /// [`Error::Value`] for an unknown word, or a set that the machine lacks.
    pub fn wished() -> Result<Option<Self>> {
        let Some(word) = std::env::var_os("MULTUM_SIMD").filter(|word| !word.is_empty()) else {
            return Ok(None);
        };
        let found = Self::NAMES.iter().find(|(name, isa)| word == *name && isa.is_supported());
        found.map(|(_, isa)| Some(*isa)).ok_or_else(|| {
            let here: Vec<&str> =
                Self::NAMES.iter().filter(|(_, isa)| isa.is_supported()).map(|(name, _)| *name).collect();
            Error::value("MULTUM_SIMD", format!("{word:?}"), format!("one of {here:?}"))
        })
    }

    /// The set that kernels use on this thread: the one forced by [`with_isa`], else the one that the
    /// environment variable `MULTUM_SIMD` names, else the best there is, also where [`Isa::wished`] finds fault with
    /// the variable.
    pub fn current() -> Self {
        static DEFAULT: OnceLock<Isa> = OnceLock::new();
        FORCED.get().unwrap_or_else(|| {
            *DEFAULT.get_or_init(|| {
                let best = Self::available().pop().unwrap_or(Self::Scalar);
                Self::wished().ok().flatten().unwrap_or(best)
            })
        })
    }
}

/// Runs `work` with every kernel on this thread using `isa`. Kernels must read [`Isa::current`] on the
/// calling thread, before work is handed to others.
///
/// # Errors
/// [`Error::Value`] when the machine lacks the set.
pub fn with_isa<R>(isa: Isa, work: impl FnOnce() -> R) -> Result<R> {
    if !isa.is_supported() {
        return Err(Error::value("isa", format!("{isa:?}"), format!("one of {:?}", Isa::available())));
    }
    let before = FORCED.replace(Some(isa));
    let result = work();
    FORCED.set(before);
    Ok(result)
}

/// Work that is compiled for an instruction set. A closure would do, but only a method can be inlined for certain, and what is
/// not inlined is not compiled for the set.
pub trait Work {
    /// What it gives.
    type Output;
    /// Does it; to be marked `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

impl<R, F: FnOnce() -> R> Work for F {
    type Output = R;
    #[inline(always)]
    fn run(self) -> R {
        self()
    }
}

/// Runs `work` compiled for `isa`: whatever is inlined into it may use the set's instructions. The
/// operations are the same, none is fused, and so are the results.
#[inline(always)]
pub fn compiled_for<W: Work>(isa: Isa, work: W) -> W::Output {
    match isa {
        // SAFETY: a set other than `Scalar` is in use only where the machine has it.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 | Isa::Avx512 if isa.is_supported() => unsafe { with_avx2(work) },
        _ => work.run(),
    }
}

/// # Safety
/// The machine must have AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn with_avx2<W: Work>(work: W) -> W::Output {
    work.run()
}
