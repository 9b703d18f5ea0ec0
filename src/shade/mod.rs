//! Light on surfaces: one law a file, each on plain numbers, without meshes, pixels or threads.
//!
//! ```text
//!  texture  ->  what it changes                              file
//!  colour       kd, the lit colour, a label, a light map     blend
//!  number       shininess, alpha, occlusion                  phong
//!  height       the normal                                   bump
//!  vector       the normal                                   normal
//!  panorama     what a mirror shows, light from all sides    environment/
//!  depth        whether a light is seen                      shadow
//! ```
//!
//! Heights that move the surface itself are in `render/displace`, which needs meshes. Colours are linear. Directions
//! l (to the light), v (to the eye) and n (the normal) are unit vectors that point away from the surface.

mod blend;
mod bump;
mod environment;
mod normal;
mod phong;
mod shadow;

pub use blend::{blend, over};
pub use bump::bumped;
pub use environment::{Environment, EnvironmentOptions, Harmonics, Ray, SkyForm};
pub use normal::{tangent_normal, toksvig};
pub use phong::{Lights, Phong};
pub use shadow::{DepthMap, Receiver};
