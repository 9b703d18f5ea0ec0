//! Lights: where light comes from and how much.

use crate::error::{Error, Result};

/// A light. Colours are linear: a white surface that faces a light of colour c squarely shows c.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// From everywhere alike.
    Ambient {
        /// Linear colour.
        color: [f32; 3],
    },
    /// From far away, along parallel rays.
    Directional {
        /// The way that light goes, of any length.
        direction: [f32; 3],
        /// Linear colour.
        color: [f32; 3],
    },
    /// From one place.
    Point {
        /// The place.
        position: [f32; 3],
        /// Linear colour.
        color: [f32; 3],
        /// The distance at which the light has its colour; it fades with the square of the distance. `None`
        /// for a light that does not fade.
        falloff: Option<f32>,
        /// For a spot: its axis, and the angles from the axis in radians up to which the light is full and from
        /// which there is none.
        cone: Option<([f32; 3], [f32; 2])>,
    },
}

impl Light {
    /// Refuses numbers that make no light.
    ///
    /// # Errors
    /// [`Error::Value`] for numbers that are not finite, directions without length, falloffs that are not
    /// positive and angles out of order.
    pub fn check(&self) -> Result<()> {
        let finite = |name, v: &[f32; 3]| match v.iter().all(|c| c.is_finite()) {
            true => Ok(()),
            false => Err(Error::value("lights", format!("{name} {v:?}"), "finite numbers")),
        };
        let direction_of = |v: &[f32; 3]| {
            finite("direction", v)?;
            match v.iter().any(|c| *c != 0.0) {
                true => Ok(()),
                false => Err(Error::value("lights", format!("direction {v:?}"), "a vector of some length")),
            }
        };
        match self {
            Self::Ambient { color } => finite("color", color),
            Self::Directional { direction, color } => {
                direction_of(direction)?;
                finite("color", color)
            }
            Self::Point { position, color, falloff, cone } => {
                finite("position", position)?;
                finite("color", color)?;
                if let Some(d) = falloff.filter(|d| !(*d > 0.0 && d.is_finite())) {
                    return Err(Error::value("lights", format!("falloff {d}"), "a positive distance"));
                }
                let Some((axis, [inner, outer])) = cone else { return Ok(()) };
                direction_of(axis)?;
                if !(0.0 <= *inner && inner <= outer && *outer <= std::f32::consts::PI) {
                    let got = format!("cone of {} and {} degrees", inner.to_degrees(), outer.to_degrees());
                    return Err(Error::value("lights", got, "0 <= inner <= outer <= 180"));
                }
                Ok(())
            }
        }
    }
}
