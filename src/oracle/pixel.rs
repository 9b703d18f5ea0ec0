//! The pixel filter, and one pixel whose footprint is a parallelogram or a quad.

use super::crew::Crew;
use super::gauss;
use super::integral::{Integrator, Map, Rules, Weight};
use super::options::{PixelFilter, Reconstruction};
use super::polygon::{Form, Point, Polygon, twice_area};
use super::signal::{Estimate, Signal};
use crate::error::{Error, Result};

/// Standard deviations after which the Gaussian is cut off.
const GAUSSIAN_REACH: i32 = 4;

/// A pixel filter, ready to integrate: the squares on which its weight is smooth, and rules for them.
#[derive(Clone, Debug)]
pub struct Pixel {
    /// Opposite corners of each square; empty for the point.
    pub(super) squares: Vec<[Point; 2]>,
    pub(super) weight: Weight,
    pub(super) affine: Rules,
    pub(super) projective: Rules,
}

impl Pixel {
    /// Prepares `filter` for pictures of this reconstruction.
    pub fn new(filter: PixelFilter, reconstruction: Reconstruction) -> Self {
        let grid = |from: i32, to: i32, step: f64| -> Vec<[Point; 2]> {
            let corner = |i: i32, j: i32| [f64::from(i) * step, f64::from(j) * step];
            (from..to).flat_map(|j| (from..to).map(move |i| [corner(i, j), corner(i + 1, j + 1)])).collect()
        };
        let (squares, weight) = match filter {
            PixelFilter::Point => (Vec::new(), Weight::Uniform(1.0)),
            PixelFilter::Box => (vec![[[-0.5, -0.5], [0.5, 0.5]]], Weight::Uniform(1.0)),
            PixelFilter::Tent => (grid(-1, 1, 1.0), Weight::Tent),
            PixelFilter::Gaussian { sigma } => {
                let side: f64 = (0..GAUSSIAN_REACH)
                    .flat_map(|i| gauss::interval(12).into_iter().map(move |(x, w)| (f64::from(i) + x, w)))
                    .map(|(x, w)| 2.0 * sigma * w * (-0.5 * x * x).exp())
                    .sum();
                let weight =
                    Weight::Gaussian { scale: 1.0 / (side * side), half_precision: 0.5 / (sigma * sigma) };
                (grid(-GAUSSIAN_REACH, GAUSSIAN_REACH, sigma), weight)
            }
        };
        Self {
            squares,
            weight,
            affine: Rules::new(reconstruction, weight, true),
            projective: Rules::new(reconstruction, weight, false),
        }
    }
}

impl Signal {
    /// The pixel at `uv` whose Jacobian is `jacobian[i][j] = ∂(u,v)_i / ∂(x,y)_j`:
    /// the integral of reconstruction(uv + J (s, t)) weight(s, t) ds dt.
    ///
    /// A coordinate that is not finite gives the border colour. No Jacobian, a zero one or
    /// [`PixelFilter::Point`] gives the value at the point, and one that is not finite the mean texel.
    /// `tolerance` matters to the Gaussian only; everything else is in closed form.
    ///
    /// # Errors
    /// [`Error::Value`] for footprints that repeat the texture so often that cutting them would take minutes.
    ///
    /// ```
    /// use multum::oracle::{Options, Pixel, PixelFilter, Reconstruction, Signal};
    /// let image = multum::Image::new(4, 1, 1, vec![0.0, 0.0, 1.0, 0.0]).unwrap();
    /// let signal = Signal::new(image.view(), &Options::default()).unwrap();
    /// let pixel = Pixel::new(PixelFilter::Box, Reconstruction::Bilinear);
    /// // One texel wide and at its centre: the box over the tent of one texel is 3/4.
    /// let estimate = signal.sample([0.625, 0.5], Some([[0.25, 0.0], [0.0, 0.0]]), &pixel, 0.0).unwrap();
    /// assert!((estimate.values[0] - 0.75).abs() < 1e-15);
    /// ```
    pub fn sample(
        &self,
        uv: [f64; 2],
        jacobian: Option<[[f64; 2]; 2]>,
        pixel: &Pixel,
        tolerance: f64,
    ) -> Result<Estimate> {
        let center = self.texels_of(uv);
        let [width, height] = self.size().map(|n| n as f64);
        let [[a, b], [c, d]] = jacobian.unwrap_or_default();
        let (x, y) = (
            Form { a: a * width, b: b * width, c: center[0] },
            Form { a: c * height, b: d * height, c: center[1] },
        );
        let entries = [x.a, x.b, y.a, y.b];
        if pixel.squares.is_empty() || entries == [0.0; 4] || !uv.iter().all(|c| c.is_finite()) {
            return Ok(self.finish(self.point(center), 0.0));
        }
        if !entries.iter().all(|entry| entry.is_finite()) {
            return Ok(self.finish(self.mean().to_vec(), 0.0));
        }
        self.affine_pixel("jacobian", Map::affine(x, y), pixel, tolerance)
    }

    /// One pixel under an affine map of its plane.
    pub(super) fn affine_pixel(
        &self,
        argument: &'static str,
        map: Map,
        pixel: &Pixel,
        tolerance: f64,
    ) -> Result<Estimate> {
        let map = map.near(self, [0.0; 2]);
        let mut integrator = Integrator::new(self, pixel.weight, &pixel.affine, tolerance);
        for &[from, to] in &pixel.squares {
            let square = Polygon::rectangle(from, to);
            integrator.check_extent(argument, &square, &map)?;
            integrator.add(&square, &map);
        }
        Ok(self.finish(integrator.sum, integrator.error))
    }

    /// The mean over a convex quad in uv, each piece of it weighted by its area on the texture.
    ///
    /// For a pixel seen in perspective this is *not* the truth, which weights by area on the screen
    /// ([`Signal::warp`]); the two agree for parallelograms.
    ///
    /// # Errors
    /// [`Error::Value`] when the corners are not finite, enclose no area or do not go around a convex quad,
    /// and for quads that repeat the texture so often that cutting them would take minutes.
    pub fn quad(&self, corners: [[f64; 2]; 4]) -> Result<Vec<f64>> {
        let wrong =
            |got: &str| Err(Error::value("corners", got, "the four corners of a convex quad, in order"));
        let at = corners.map(|corner| self.texels_of(corner));
        if !at.iter().flatten().all(|x| x.is_finite()) {
            return wrong("a coordinate that is not finite");
        }
        let origin = [0, 1].map(|i| self.axes[i].periods_below(at[0][i]));
        let at = at.map(|[x, y]| [x - origin[0], y - origin[1]]);
        let turn = |i: usize| {
            let [p, q, r] = [at[i], at[(i + 1) % 4], at[(i + 2) % 4]];
            (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0])
        };
        let turns = [turn(0), turn(1), turn(2), turn(3)];
        let area = 0.5 * (twice_area([at[0], at[1], at[2]]) + twice_area([at[0], at[2], at[3]]));
        let around: f64 =
            (0..4).map(|i| (at[i][0] - at[(i + 1) % 4][0]).hypot(at[i][1] - at[(i + 1) % 4][1])).sum();
        if !area.is_finite() || area <= 1e-14 * around * around {
            return wrong("a quad without area");
        }
        // Rounding may bend a straight angle.
        let slack = 1e-12 * area;
        if turns.iter().any(|t| *t > slack) && turns.iter().any(|t| *t < -slack) {
            return wrong("a quad that is concave or crosses itself");
        }
        let weight = Weight::Uniform(1.0 / area);
        let rules = Rules::new(self.reconstruction, weight, true);
        let map = Map::affine(Form { a: 1.0, b: 0.0, c: 0.0 }, Form { a: 0.0, b: 1.0, c: 0.0 });
        let polygon = Polygon::new(&at);
        let mut integrator = Integrator::new(self, weight, &rules, 0.0);
        integrator.check_extent("corners", &polygon, &map)?;
        integrator.add(&polygon, &map);
        Ok(self.finish(integrator.sum, 0.0).values)
    }

    /// [`Signal::sample`] for many pixels: `uv` holds pairs, `jacobians` their matrices, row by row.
    ///
    /// # Errors
    /// As [`Signal::sample`], for numbers that do not pair up, and [`Error::Interrupted`] if the crew is.
    pub fn samples(
        &self,
        uv: &[f64],
        jacobians: Option<&[f64]>,
        pixel: &Pixel,
        tolerance: f64,
        crew: &mut Crew<'_>,
    ) -> Result<Vec<Estimate>> {
        let (pairs, rest) = uv.as_chunks::<2>();
        if !rest.is_empty() || jacobians.is_some_and(|j| j.len() != 4 * pairs.len()) {
            return Err(Error::value("jacobian", "another number of matrices", "one for each pair of uv"));
        }
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(Error::value("tol", tolerance, "a number above 0"));
        }
        each(pairs, crew, |i, &place| {
            let jacobian =
                jacobians.map(|all| [[all[4 * i], all[4 * i + 1]], [all[4 * i + 2], all[4 * i + 3]]]);
            self.sample(place, jacobian, pixel, tolerance)
        })
    }

    /// [`Signal::quad`] for many quads: four pairs each.
    ///
    /// # Errors
    /// As [`Signal::quad`], and [`Error::Interrupted`] if the crew is.
    pub fn quads(&self, corners: &[f64], crew: &mut Crew<'_>) -> Result<Vec<Estimate>> {
        let (quads, rest) = corners.as_chunks::<8>();
        if !rest.is_empty() {
            return Err(Error::value("corners", format!("{} numbers", corners.len()), "eight a quad"));
        }
        each(quads, crew, |_, q| {
            let values = self.quad([[q[0], q[1]], [q[2], q[3]], [q[4], q[5]], [q[6], q[7]]])?;
            Ok(Estimate { values, error: 0.0 })
        })
    }
}

/// One estimate for each item, by all of the crew.
fn each<T: Sync>(
    items: &[T],
    crew: &mut Crew<'_>,
    work: impl Fn(usize, &T) -> Result<Estimate> + Sync,
) -> Result<Vec<Estimate>> {
    const SHARE: usize = 16;
    let mut estimates = vec![Estimate { values: Vec::new(), error: 0.0 }; items.len()];
    let shares = estimates.chunks_mut(SHARE).zip(items.chunks(SHARE)).enumerate();
    crew.each(shares, |(n, (estimates, items))| {
        for (i, (estimate, item)) in estimates.iter_mut().zip(items).enumerate() {
            *estimate = work(n * SHARE + i, item)?;
        }
        Ok(())
    })?;
    Ok(estimates)
}
