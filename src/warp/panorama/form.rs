//! The forms of a panorama, and where each of them breaks off.

use crate::error::{Error, Result};
use crate::mapping::{
    Cube, DualParaboloid, Equirect, Fisheye, FisheyeModel, Layout, LightProbe, Mapping, MirrorBall,
    Octahedral, Perspective, Stereographic,
};
use crate::wrap::Wrap;
use glam::{DVec2, DVec3};

/// How a picture holds directions. Angles are in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Longitude and latitude.
    Equirect,
    /// Six faces in one picture.
    Cube(Layout),
    /// A pinhole camera that sees this angle across.
    Perspective(f64),
    /// A fisheye lens that sees this angle.
    Fisheye(FisheyeModel, f64),
    /// The angular map.
    LightProbe,
    /// The photograph of a mirror ball.
    MirrorBall,
    /// The stereographic picture of this angle.
    Stereographic(f64),
    /// Two discs.
    DualParaboloid,
    /// The unfolded octahedron.
    Octahedral,
}

/// Parts a side into which a pixel is cut at most.
const MOST_PARTS: f64 = 16.0;
/// Angle, in radians, over which a map counts as straight.
const STRAIGHT: f64 = 0.1;

impl Form {
    /// The map between directions and this form's picture of `width` by `height` pixels.
    ///
    /// # Errors
    /// [`Error::Value`] for an angle the form cannot have, and for a cube picture without square cells.
    pub fn mapping(self, argument: &'static str, width: usize, height: usize) -> Result<Box<dyn Mapping>> {
        Ok(match self {
            Self::Equirect => Box::new(Equirect),
            Self::Cube(layout) => {
                let (columns, rows) = layout.cells();
                let side = width / columns;
                if side == 0 || [width, height] != [columns * side, rows * side] {
                    let got = format!("{width}x{height} (width x height)");
                    let expected = format!("{columns} by {rows} square cells");
                    return Err(Error::value(argument, got, expected));
                }
                Box::new(Cube::new(layout, DVec3::ZERO)?)
            }
            Self::Perspective(fov) => Box::new(Perspective::new(fov, width as f64 / height as f64)?),
            Self::Fisheye(model, fov) => Box::new(Fisheye::new(model, fov)?),
            Self::LightProbe => Box::new(LightProbe),
            Self::MirrorBall => Box::new(MirrorBall),
            Self::Stereographic(fov) => Box::new(Stereographic::new(fov)?),
            Self::DualParaboloid => Box::new(DualParaboloid),
            Self::Octahedral => Box::new(Octahedral),
        })
    }

    /// What lies beyond the sides of the picture.
    pub(super) fn wrap(self) -> [Wrap; 2] {
        match self {
            Self::Equirect => [Wrap::Repeat, Wrap::Clamp],
            Self::Perspective(_) | Self::Stereographic(_) => [Wrap::Border; 2],
            _ => [Wrap::Clamp; 2],
        }
    }

    /// The convex piece of the picture around a place on which the inverse map is smooth; `None` where there is none.
    pub(super) fn piece(self, uv: DVec2) -> Option<usize> {
        let disc = |centre: DVec2, scale: DVec2| ((uv - centre) / scale).length_squared() <= 1.0;
        match self {
            Self::Equirect | Self::Perspective(_) | Self::Stereographic(_) => Some(0),
            Self::Cube(layout) => {
                let (columns, rows) = layout.cells();
                let cell = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
                Some(cell(uv.y, rows) * columns + cell(uv.x, columns))
            }
            Self::Fisheye(..) | Self::LightProbe | Self::MirrorBall => {
                disc(DVec2::splat(0.5), DVec2::splat(0.5)).then_some(0)
            }
            Self::DualParaboloid => {
                let right = usize::from(uv.x >= 0.5);
                disc(DVec2::new(0.25 + 0.5 * right as f64, 0.5), DVec2::new(0.25, 0.5)).then_some(right)
            }
            Self::Octahedral => {
                let q = uv - 0.5;
                let outside = q.x.abs() + q.y.abs() > 0.5;
                Some(usize::from(q.x < 0.0) + 2 * usize::from(q.y < 0.0) + 4 * usize::from(outside))
            }
        }
    }

    /// The piece of the sphere around a direction on which the map is smooth; `uv` is its place in a picture of
    /// `size` pixels. `None` next to the rim of a disc.
    pub(super) fn patch(self, d: DVec3, uv: DVec2, [width, height]: [usize; 2]) -> Option<usize> {
        /// Pixels from the rim.
        const RIM: f64 = 2.0;
        let inside = |centre: DVec2, radius: DVec2| {
            let margin = RIM / DVec2::new(width as f64, height as f64);
            ((uv - centre) / (radius - margin).max(DVec2::splat(1e-9))).length_squared() < 1.0
        };
        match self {
            Self::Equirect | Self::Perspective(_) | Self::Stereographic(_) | Self::Cube(_) => Some(0),
            Self::Fisheye(..) | Self::LightProbe | Self::MirrorBall => {
                inside(DVec2::splat(0.5), DVec2::splat(0.5)).then_some(0)
            }
            Self::DualParaboloid => {
                let right = usize::from(d.z < 0.0);
                inside(DVec2::new(0.25 + 0.5 * right as f64, 0.5), DVec2::new(0.25, 0.5)).then_some(right)
            }
            Self::Octahedral => {
                Some(usize::from(d.x < 0.0) + 2 * usize::from(d.y < 0.0) + 4 * usize::from(d.z < 0.0))
            }
        }
    }

    /// Into how many parts a side a pixel of `reach` radians around `d` is cut, so that the map to this form is
    /// close to linear on each part: more towards a pole, some across an edge, else one.
    pub(super) fn parts(self, d: DVec3, reach: f64) -> usize {
        let near = |distance: f64| 4.0 * reach / distance;
        let across = |distance: f64| if distance < reach { 4.0 } else { 1.0 };
        let a = d.abs();
        let wanted = match self {
            Self::Equirect => near(d.x.hypot(d.z)),
            Self::LightProbe | Self::Fisheye(..) if d.z < 0.0 => near(d.x.hypot(d.y)),
            Self::MirrorBall if d.z > 0.0 => near(d.x.hypot(d.y)),
            Self::Cube(_) => {
                let largest = a.max_element();
                let second = a.x.min(a.y).max(a.y.min(a.z)).max(a.x.min(a.z));
                across((largest - second) / largest)
            }
            Self::DualParaboloid => across(a.z),
            Self::Octahedral => across(a.min_element()),
            _ => 1.0,
        };
        // A NaN or infinite wish ends at the limit.
        wanted.max(reach / STRAIGHT).ceil().clamp(1.0, MOST_PARTS) as usize
    }
}
