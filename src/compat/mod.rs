//! Rules of other libraries, where they are not those of this crate: what the drop-ins of the Python module
//! are made of.

pub mod cv2;
pub mod torch;
