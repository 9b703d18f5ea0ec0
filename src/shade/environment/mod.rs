//! Environment maps: light from all sides, as far away as the sky.
//!
//! ```text
//! scenes (glTF)   x right, y up, z towards the viewer        panoramas   x right, y up, z forward
//! ```
//!
//! so that the middle of a panorama is what a camera that looks along -z sees. A mirror shows the light of the
//! reflected ray, averaged over the piece of the map that a pixel's reflected rays meet; less smooth surfaces that
//! of the prefiltered pyramid ([`prefilter`]), matt ones that of spherical harmonics ([`Harmonics`]).
//!
//! Blinn and Newell, "Texture and reflection in computer generated images", CACM 1976.

mod harmonics;
mod prefilter;

use crate::encode::Encoding;
use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::image::{AnyView, View};
use crate::mapping::{Layout, LightProbe, Mapping, MirrorBall, SurfacePoint};
use crate::sampler::{Extent, Sampler};
use crate::sphere::{SphereTexture, Spread};
use crate::texture::{Texture, TextureOptions};
use glam::{DMat3, DVec3, Vec3};

pub use harmonics::Harmonics;

/// Turns the axes of scenes into those of panoramas, and back.
const FLIP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::NEG_Z);

/// A direction of any length, and its movement for one pixel right and one pixel down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The direction, away from the surface.
    pub direction: DVec3,
    /// ∂/∂x and ∂/∂y.
    pub moving: [DVec3; 2],
}

impl Ray {
    /// The ray that a mirror sends on: r = d - 2 (d·n) n for a ray d from the eye and a unit normal n.
    ///
    /// Its movement is that formula's derivative, `dr = dd - 2 ((d·n) dn + (dd·n + d·dn) n)`.
    /// Igehy, "Tracing ray differentials", SIGGRAPH 1999.
    ///
    /// ```
    /// use glam::DVec3;
    /// use multum::shade::Ray;
    /// let seen = Ray { direction: DVec3::new(1.0, -1.0, 0.0), moving: [DVec3::Z, DVec3::ZERO] };
    /// let mirrored = seen.mirrored(DVec3::Y, [DVec3::ZERO; 2]); // a flat mirror
    /// assert_eq!(mirrored.direction, DVec3::new(1.0, 1.0, 0.0));
    /// assert_eq!(mirrored.moving, [DVec3::Z, DVec3::ZERO]);
    /// ```
    pub fn mirrored(self, n: DVec3, dn: [DVec3; 2]) -> Self {
        let d = self.direction;
        let along = d.dot(n);
        let moving = std::array::from_fn(|k| {
            let dd = self.moving[k];
            dd - 2.0 * (along * dn[k] + (dd.dot(n) + d.dot(dn[k])) * n)
        });
        Self { direction: d - 2.0 * along * n, moving }
    }

    fn turned(self, by: DMat3) -> Self {
        Self { direction: by * self.direction, moving: self.moving.map(|d| by * d) }
    }
}

/// How a picture holds directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum SkyForm {
    /// Longitude and latitude.
    #[default]
    Equirect,
    /// Six faces in one picture.
    Cube(Layout),
    /// The angular map: a light probe.
    LightProbe,
    /// The photograph of a mirror ball.
    MirrorBall,
}

/// A picture and the way to it.
enum Sky {
    Sphere(SphereTexture),
    Disc(Box<Texture<'static>>, Box<dyn Mapping>),
}

/// Light from all sides.
pub struct Environment {
    mirror: Sky,
    /// One for each of [`prefilter::EXPONENTS`].
    blurred: Vec<Sky>,
    harmonics: Harmonics,
    turn: DMat3,
    follows_eye: bool,
    intensity: f32,
}

impl std::fmt::Debug for Environment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Environment(harmonics: {:?}, intensity: {})", self.harmonics, self.intensity)
    }
}

/// How a picture becomes an [`Environment`].
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentOptions {
    /// How the picture holds directions.
    pub form: SkyForm,
    /// Whether directions are those of the eye's own space rather than of the scene: OpenGL's sphere map is a
    /// [`SkyForm::MirrorBall`] that does.
    pub follows_eye: bool,
    /// What the picture's codes mean.
    pub encoding: Encoding,
    /// The environment is turned so far about the scene's y axis, counter-clockwise seen from above, in radians.
    pub yaw_rad: f64,
    /// Multiplies the light.
    pub intensity: f32,
}

impl Default for EnvironmentOptions {
    fn default() -> Self {
        Self {
            form: SkyForm::Equirect,
            follows_eye: false,
            encoding: Encoding::Linear,
            yaw_rad: 0.0,
            intensity: 1.0,
        }
    }
}

impl Environment {
    /// An environment from a picture of one channel (grey), three or four (the fourth is not read).
    ///
    /// # Errors
    /// [`Error::Value`] for a picture that the form cannot have, other channels, and numbers that are not finite.
    pub fn new(image: AnyView<'_>, options: &EnvironmentOptions) -> Result<Self> {
        if !matches!(image.channels(), 1 | 3 | 4) {
            return Err(Error::value(
                "image",
                format!("{} channels", image.channels()),
                "1, 3 or 4 channels",
            ));
        }
        if !options.yaw_rad.is_finite() {
            return Err(Error::value("rotation", options.yaw_rad, "a finite number"));
        }
        if !(options.intensity >= 0.0 && options.intensity.is_finite()) {
            return Err(Error::value("intensity", options.intensity, "a finite number, not negative"));
        }
        let texture = TextureOptions { encoding: options.encoding, ..TextureOptions::default() };
        let mirror = match options.form {
            SkyForm::Equirect => Sky::Sphere(SphereTexture::equirect(image, texture)?),
            SkyForm::Cube(layout) => Sky::Sphere(SphereTexture::cube(image, layout, texture)?),
            SkyForm::LightProbe => Sky::Disc(Box::new(Texture::new(image, texture)?), Box::new(LightProbe)),
            SkyForm::MirrorBall => Sky::Disc(Box::new(Texture::new(image, texture)?), Box::new(MirrorBall)),
        };
        let mut made = Self {
            mirror,
            blurred: Vec::new(),
            harmonics: Harmonics::default(),
            turn: FLIP * DMat3::from_rotation_y(-options.yaw_rad),
            follows_eye: options.follows_eye,
            intensity: options.intensity,
        };
        for (k, p) in prefilter::EXPONENTS.into_iter().enumerate() {
            let rows = prefilter::rows(p);
            let light = made.lat_long(rows)?;
            if k == 0 {
                for (i, texel) in light.iter().enumerate() {
                    let (row, column) = (i / (2 * rows), i % (2 * rows));
                    let at = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
                    let direction = prefilter::direction(at(column, 2 * rows), at(row, rows));
                    let color = Vec3::from(*texel).as_dvec3();
                    made.harmonics.add(direction, color, prefilter::solid_angle(row, rows));
                }
            }
            let texels = prefilter::lobe(&light, rows, p)?;
            let view = View::new(texels.as_flattened(), 2 * rows, rows, 3, 6 * rows)?;
            made.blurred.push(Sky::Sphere(SphereTexture::equirect(view.into(), TextureOptions::default())?));
        }
        Ok(made)
    }

    /// The mirrored picture as a lat-long one of `rows` by `2 rows` texels.
    fn lat_long(&self, rows: usize) -> Result<Vec<[f32; 3]>> {
        let columns = 2 * rows;
        let rays = (0..rows * columns).map(|i| {
            let (u, v) = ((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5);
            let at = |u: f64, v: f64| prefilter::direction(u / columns as f64, v / rows as f64);
            // Chords over a texel: exact enough for the piece of sky that it covers.
            let moving = [at(u + 0.5, v) - at(u - 0.5, v), at(u, v + 0.5) - at(u, v - 0.5)];
            Ray { direction: at(u, v), moving }
        });
        look(&self.mirror, &rays.collect::<Vec<_>>(), &Sampler::new(Filter::Area))
    }

    /// From the scene to the picture, for a camera with this rotation from world to eye space.
    fn turn(&self, eye: DMat3) -> DMat3 {
        if self.follows_eye { self.turn * eye } else { self.turn }
    }

    /// What a white matt surface with this unit normal shows. `eye` turns world space into the eye's.
    pub fn diffuse(&self, n: Vec3, eye: DMat3) -> Vec3 {
        self.harmonics.diffuse((self.turn(eye) * n.as_dvec3()).as_vec3()) * self.intensity
    }

    /// The light along each ray, averaged by a Phong lobe of its exponent (infinity: a mirror) and over what the
    /// ray's movement covers.
    ///
    /// # Errors
    /// [`Error::Value`] when there are not as many exponents as rays, or the sampler's options are out of range.
    pub fn mirrored(
        &self,
        rays: &[Ray],
        exponents: &[f32],
        eye: DMat3,
        sampler: &Sampler,
    ) -> Result<Vec<Vec3>> {
        if rays.len() != exponents.len() {
            let got = format!("{} numbers", exponents.len());
            return Err(Error::value("exponents", got, format!("one a ray, {}", rays.len())));
        }
        let turn = self.turn(eye);
        let rays: Vec<Ray> = rays.iter().map(|r| r.turned(turn)).collect();
        let places: Vec<(isize, f64)> = exponents.iter().map(|&p| prefilter::between(p.into())).collect();
        let mut out = vec![Vec3::ZERO; rays.len()];
        for (k, source) in std::iter::once(&self.mirror).chain(&self.blurred).enumerate() {
            let weight = |(sharper, share): (isize, f64)| match k as isize - 1 - sharper {
                0 => 1.0 - share,
                1 => share,
                _ => 0.0,
            };
            let own: Vec<usize> = (0..rays.len()).filter(|&i| weight(places[i]) > 0.0).collect();
            let picked: Vec<Ray> = own.iter().map(|&i| rays[i]).collect();
            for (i, light) in own.into_iter().zip(look(source, &picked, sampler)?) {
                out[i] += Vec3::from(light) * (weight(places[i]) as f32 * self.intensity);
            }
        }
        Ok(out)
    }
}

/// The light along rays in the frame of the picture.
fn look(sky: &Sky, rays: &[Ray], sampler: &Sampler) -> Result<Vec<[f32; 3]>> {
    let (channels, values) = match sky {
        Sky::Sphere(sphere) => {
            let directions: Vec<f64> = rays.iter().flat_map(|r| r.direction.to_array()).collect();
            let [x, y] =
                [0, 1].map(|k| rays.iter().flat_map(|r| r.moving[k].to_array()).collect::<Vec<f64>>());
            let mut values = vec![0f32; rays.len() * sphere.channels()];
            sphere.sample(sampler, &directions, Spread::Tangents(&x, &y), &mut values)?;
            (sphere.channels(), values)
        }
        Sky::Disc(texture, map) => {
            let (mut uv, mut jacobian) = (Vec::new(), Vec::new());
            for ray in rays {
                let at = map.at(&SurfacePoint::new(ray.direction).moving(ray.moving[0], ray.moving[1]));
                uv.extend(at.uv.to_array());
                jacobian.extend(at.jacobian.m.as_flattened());
            }
            let mut values = vec![0f32; rays.len() * texture.channels()];
            sampler.sample(texture, &uv, Extent::Jacobian(&jacobian), &mut values)?;
            (texture.channels(), values)
        }
    };
    let color = |texel: &[f32]| if let [r, g, b, ..] = *texel { [r, g, b] } else { [texel[0]; 3] };
    Ok(values.chunks_exact(channels).map(color).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(form: SkyForm, width: usize, height: usize) -> Environment {
        let data = vec![0.75f32; width * height * 3];
        let view = View::new(&data, width, height, 3, 3 * width).expect("a view");
        Environment::new(view.into(), &EnvironmentOptions { form, ..Default::default() }).expect("fits")
    }

    #[test]
    fn a_constant_sky_is_that_constant_for_every_form_and_lobe() {
        let forms = [
            (SkyForm::Equirect, 64, 32),
            (SkyForm::Cube(Layout::Strip), 96, 16),
            (SkyForm::LightProbe, 48, 48),
            (SkyForm::MirrorBall, 48, 48),
        ];
        for (form, w, h) in forms {
            let sky = constant(form, w, h);
            let n = Vec3::new(0.48, 0.6, -0.64);
            assert!((sky.diffuse(n, DMat3::IDENTITY) - 0.75).abs().max_element() < 1e-4, "{form:?}");
            let ray = Ray { direction: n.as_dvec3(), moving: [DVec3::X * 0.01, DVec3::Y * 0.03] };
            let exponents = [f32::INFINITY, 5000.0, 300.0, 20.0, 1.5, 0.1];
            let lit = sky.mirrored(&[ray; 6], &exponents, DMat3::IDENTITY, &Sampler::default()).expect("lit");
            for (p, light) in exponents.iter().zip(lit) {
                assert!((light - 0.75).abs().max_element() < 1e-5, "{form:?} {p}: {light}");
            }
        }
    }

    /// Against the integral of the lobe itself, for light that is not constant.
    #[test]
    fn lobes_average_as_their_formula_says() {
        let (rows, columns) = (64, 128);
        let sky = |d: DVec3| 1.0 + 0.8 * d.x * d.z + 0.5 * d.y;
        let data: Vec<f32> = (0..rows * columns)
            .map(|i| {
                let at = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
                sky(prefilter::direction(at(i % columns, columns), at(i / columns, rows))) as f32
            })
            .collect();
        let view = View::new(&data, columns, rows, 1, columns).expect("a view");
        let made = Environment::new(view.into(), &EnvironmentOptions::default()).expect("fits");
        let r = DVec3::new(0.36, 0.48, 0.8);
        for p in [1.0, 4.0, 10.0, 64.0, 700.0] {
            // In the lobe's own frame the mean of a polynomial of degree 2 has a closed form: along the axis
            // z the mean of z is (p+1)/(p+2), of z² (p+1)/(p+3), of x² and y² half of the rest.
            let (m1, m2) = ((p + 1.0) / (p + 2.0), (p + 1.0) / (p + 3.0));
            let side = 0.5 * (1.0 - m2);
            let map = FLIP * r;
            let exact = 1.0 + 0.5 * m1 * map.y + 0.8 * (m2 - side) * map.x * map.z;
            let ray = Ray { direction: r, moving: [DVec3::ZERO; 2] };
            let got = made.mirrored(&[ray], &[p as f32], DMat3::IDENTITY, &Sampler::default()).expect("lit");
            // Mixing two lobes by the mean square of their spread is right to the order of that square's own.
            assert!((f64::from(got[0].x) - exact).abs() < 0.01, "{p}: {} {exact}", got[0].x);
        }
    }
}
