//! The single place that turns errors of the crate into Python exceptions.

use crate::error::Error;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyTypeError, PyValueError};
use pyo3::prelude::*;

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        let text = error.to_string();
        match error {
            Error::Value { .. } => PyValueError::new_err(text),
            Error::Type { .. } => PyTypeError::new_err(text),
            Error::Io { source, path } => {
                let code = source.raw_os_error();
                let path = path.display().to_string();
                match code {
                    // With a code Python picks the subclass, such as FileNotFoundError.
                    Some(code) => PyOSError::new_err((code, source.to_string(), path)),
                    None => PyOSError::new_err(text),
                }
            }
            Error::File { .. } => PyOSError::new_err(text),
            Error::Interrupted => Python::attach(|py| {
                PyErr::take(py).unwrap_or_else(|| PyKeyboardInterrupt::new_err("interrupted"))
            }),
        }
    }
}
