//! The one error type of the crate, sorted by who can mend the cause.

use std::path::PathBuf;

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong. Each message names the argument, what it was and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument has a value that the function cannot use. Python: `ValueError`.
    #[error("{argument}: got {got}, expected {expected}")]
    Value {
        /// Name of the argument as the caller wrote it.
        argument: &'static str,
        /// What was passed.
        got: String,
        /// What would have been accepted.
        expected: String,
    },
    /// An argument has a type or dtype that the function does not take. Python: `TypeError`.
    #[error("{argument}: got {got}, expected {expected}")]
    Type {
        /// Name of the argument as the caller wrote it.
        argument: &'static str,
        /// What was passed.
        got: String,
        /// What would have been accepted.
        expected: String,
    },
    /// The operating system refused a file operation. Python: `OSError`.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's own error.
        source: std::io::Error,
    },
    /// A file's content is damaged, hostile or of an unknown kind. Python: `OSError`.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it and what would be read.
        message: String,
    },
    /// The caller asked to stop (Ctrl-C). Python: the pending exception, usually `KeyboardInterrupt`.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// A [`Error::Value`] from anything printable.
    pub fn value(argument: &'static str, got: impl ToString, expected: impl ToString) -> Self {
        Self::Value { argument, got: got.to_string(), expected: expected.to_string() }
    }

    /// A [`Error::Type`] from anything printable.
    pub fn type_(argument: &'static str, got: impl ToString, expected: impl ToString) -> Self {
        Self::Type { argument, got: got.to_string(), expected: expected.to_string() }
    }
}
