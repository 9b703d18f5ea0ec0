//! What is read where a sample meets the high mesh, and how it is averaged.

use super::cast::{Caster, Sample};
use super::cover::Chart;
use super::surface::{Place, Surface};
use super::tree::{Stack, Tree};
use crate::error::{Error, Result};
use crate::sampler::{Extent, Sampler};
use crate::texture::Texture;
use glam::DVec3;

/// In which axes normals are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// Those of the low mesh's tangent frame: x along the tangent, y along the bitangent, z along the normal.
    #[default]
    Tangent,
    /// Those of the meshes' positions.
    Object,
}

impl Space {
    /// The value of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word than "tangent" and "object".
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        match name {
            "tangent" => Ok(Self::Tangent),
            "object" => Ok(Self::Object),
            _ => Err(Error::value(argument, format!("{name:?}"), "\"tangent\" or \"object\"")),
        }
    }
}

/// A material's colour: linear numbers, multiplied by a texture where there is one.
#[derive(Clone, Copy, Debug)]
pub struct Paint<'a> {
    /// Linear red, green and blue.
    pub color: [f32; 3],
    /// The texture.
    pub texture: Option<&'a Texture<'static>>,
    /// Which uv set of the mesh it is read with.
    pub uv_set: usize,
    /// Rows (a, b, c) and (d, e, f): it is read at (a u + b v + c, d u + e v + f).
    pub transform: [[f32; 3]; 2],
}

/// What a map holds.
#[derive(Clone, Copy, Debug)]
pub enum Map<'a> {
    /// Unit normals: the high mesh's interpolated ones, averaged as directions.
    Normal(Space),
    /// How far the high mesh lies from the low mesh along the cage direction, in the meshes' unit: the low mesh
    /// moved by it is the high mesh.
    Height,
    /// Places on the high mesh.
    Position,
    /// Share of the sky that a point of the high mesh sees: rays of the upper hemisphere about the face's
    /// normal, weighted by the cosine, that meet nothing of the high mesh within `radius`.
    Occlusion {
        /// Rays a texel, shared among its samples.
        rays: usize,
        /// How far is looked, in the meshes' unit; infinity for all the way.
        radius: f64,
    },
    /// Mean curvature of the high mesh in 1 / unit, positive where it is convex: 1 / r on a sphere.
    Curvature,
    /// Linear colour of the high mesh's materials, one [`Paint`] a material, read with the footprint of each
    /// sample point.
    Color(&'a [Paint<'a>]),
}

/// A map with what it needs to be read.
pub(super) struct Quantity<'a> {
    map: &'a Map<'a>,
    high: &'a Surface<'a>,
    low: &'a Surface<'a>,
    chart: &'a Chart,
    tree: &'a Tree,
    curvature: Vec<f32>,
}

impl<'a> Quantity<'a> {
    pub fn new(
        map: &'a Map<'a>,
        high: &'a Surface<'a>,
        low: &'a Surface<'a>,
        chart: &'a Chart,
        caster: &'a Caster<'a>,
    ) -> Result<Self> {
        let mut curvature = Vec::new();
        match map {
            Map::Occlusion { rays, radius } => {
                const MOST: usize = 65536;
                if !(1..=MOST).contains(rays) {
                    return Err(Error::value("rays", rays, format!("1 to {MOST}")));
                }
                if radius.is_nan() || *radius <= 0.0 {
                    return Err(Error::value("radius", radius, "a positive number"));
                }
            }
            Map::Curvature => curvature = high.curvature(),
            Map::Color(paints) => {
                let count = high.mesh.materials.len();
                if paints.len() != count {
                    let got = format!("{} paints", paints.len());
                    return Err(Error::value("paints", got, format!("one a material, {count}")));
                }
                let sets = high.mesh.uv.len();
                if let Some(paint) = paints.iter().find(|p| p.texture.is_some() && p.uv_set >= sets) {
                    return Err(Error::value(
                        "paints",
                        format!("uv set {}", paint.uv_set),
                        format!("below {sets}"),
                    ));
                }
            }
            Map::Normal(_) | Map::Height | Map::Position => {}
        }
        Ok(Self { map, high, low, chart, tree: caster.tree(), curvature })
    }

    pub fn channels(&self) -> usize {
        match self.map {
            Map::Normal(_) | Map::Position | Map::Color(_) => 3,
            Map::Height | Map::Occlusion { .. } | Map::Curvature => 1,
        }
    }

    /// The value of texels that nothing fills.
    pub fn background(&self) -> [f32; 4] {
        match self.map {
            Map::Normal(Space::Tangent) => [0.0, 0.0, 1.0, 0.0],
            Map::Occlusion { .. } => [1.0, 0.0, 0.0, 0.0],
            _ => [0.0; 4],
        }
    }

    pub fn samples_per_texel(&self) -> usize {
        self.chart.samples_per_texel()
    }

    /// The mean of a texel's samples; of directions that cancel out, the first.
    pub fn mean(&self, sum: [f64; 4], count: usize, first: [f32; 4]) -> [f32; 4] {
        match self.map {
            Map::Normal(_) => {
                let sum = DVec3::new(sum[0], sum[1], sum[2]);
                if sum.length() > 1e-6 * count as f64 { narrow(sum.normalize()) } else { first }
            }
            _ => sum.map(|s| (s / count as f64) as f32),
        }
    }

    /// The numbers of a tile's samples. `texel` tells the texel of a sample.
    pub fn values(
        &self,
        samples: &[Sample],
        stack: &mut Stack,
        texel: impl Fn(usize) -> [usize; 2],
    ) -> Result<Vec<[f32; 4]>> {
        if let Map::Color(paints) = self.map {
            return self.colors(paints, samples);
        }
        let mut place = [usize::MAX; 2];
        let mut order = 0;
        let value = |(i, s): (usize, &Sample)| match self.map {
            Map::Normal(Space::Object) => narrow(self.high.normal(s.high)),
            Map::Normal(Space::Tangent) => {
                let normal = self.high.normal(s.high);
                narrow(self.low.frame(s.low).coordinates(normal).unwrap_or(DVec3::Z))
            }
            Map::Height => [s.height as f32, 0.0, 0.0, 0.0],
            Map::Position => narrow(s.point),
            Map::Curvature => [self.high.mix_scalar(&self.curvature, s.high) as f32, 0.0, 0.0, 0.0],
            Map::Occlusion { rays, radius } => {
                let own = texel(i);
                order = if own == place { order + 1 } else { 0 };
                place = own;
                [self.sky(stack, s, own, order, *rays, *radius) as f32, 0.0, 0.0, 0.0]
            }
            Map::Color(_) => [0.0; 4],
        };
        Ok(samples.iter().enumerate().map(value).collect())
    }

    /// The share of the sky that sample `order` of a texel sees.
    fn sky(
        &self,
        stack: &mut Stack,
        s: &Sample,
        texel: [usize; 2],
        order: usize,
        rays: usize,
        radius: f64,
    ) -> f64 {
        let normal = self.high.face_normal(s.high.face);
        let (x, y) = normal.any_orthonormal_pair();
        // Off the surface by more than the rounding of single precision.
        let extent = self.tree.extent();
        let origin = s.point + 2e-6 * extent * normal;
        let far = radius.min(4.0 * extent + s.point.length());
        let count = rays.div_ceil(self.samples_per_texel());
        let turn = [hash(texel, 0), hash(texel, 1)];
        let mut open = 0;
        for i in 0..count {
            // Points of the R2 sequence, turned by another amount in each texel: even within a texel, and with
            // no pattern from texel to texel. Roberts, "The unreasonable effectiveness of quasirandom
            // sequences", 2018.
            let k = (order * count + i) as f64;
            let a = (turn[0] + k * 0.754_877_666_246_692_8).fract();
            let b = (turn[1] + k * 0.569_840_290_998_053_2).fract();
            // Malley's method: a point on the disc, lifted to the hemisphere.
            let (sin, cos) = (std::f64::consts::TAU * b).sin_cos();
            let r = a.sqrt();
            let direction = (x * (r * cos) + y * (r * sin) + normal * (1.0 - a).sqrt()).normalize();
            let mut met = false;
            self.tree.crossings(stack, origin, direction, [0.0, far], |_, _| {
                met = true;
                false
            });
            open += usize::from(!met);
        }
        open as f64 / count as f64
    }

    /// Colours, material by material.
    fn colors(&self, paints: &[Paint<'_>], samples: &[Sample]) -> Result<Vec<[f32; 4]>> {
        let mut values = vec![[0.0f32; 4]; samples.len()];
        for (m, paint) in paints.iter().enumerate() {
            let own: Vec<usize> = (0..samples.len())
                .filter(|&i| self.high.mesh.face_material[samples[i].high.face as usize] as usize == m)
                .collect();
            let mut colors = vec![[1.0f32; 3]; own.len()];
            if let Some(texture) = paint.texture.filter(|_| !own.is_empty()) {
                let places: Vec<_> = own.iter().map(|&i| self.footprint(&samples[i], paint)).collect();
                let uv: Vec<f64> = places.iter().flat_map(|(uv, _)| *uv).collect();
                let jacobians: Vec<f64> = places.iter().flat_map(|(_, j)| *j).collect();
                let channels = texture.channels();
                let mut read = vec![0.0f32; own.len() * channels];
                Sampler::default().sample(texture, &uv, Extent::Jacobian(&jacobians), &mut read)?;
                for (color, read) in colors.iter_mut().zip(read.chunks_exact(channels)) {
                    *color = if channels < 3 { [read[0]; 3] } else { [read[0], read[1], read[2]] };
                }
            }
            for (&i, color) in own.iter().zip(colors) {
                let vertex = self.vertex_color(samples[i].high);
                for k in 0..3 {
                    values[i][k] = color[k] * paint.color[k] * vertex[k];
                }
            }
        }
        Ok(values)
    }

    fn vertex_color(&self, at: Place) -> [f32; 3] {
        let mesh = self.high.mesh;
        if mesh.colors.is_empty() {
            return [1.0; 3];
        }
        let corners = mesh.faces[at.face as usize].map(|v| mesh.colors[v as usize]);
        std::array::from_fn(|k| (0..3).map(|c| corners[c][k] * at.weights[c] as f32).sum())
    }

    /// Where a sample reads a texture of the high mesh, and how far that moves from one sample point to the
    /// next: right (du/dx, dv/dx in columns) and down.
    fn footprint(&self, s: &Sample, paint: &Paint<'_>) -> ([f64; 2], [f64; 4]) {
        let set = &self.high.mesh.uv[paint.uv_set];
        let corners = self.high.mesh.faces[s.high.face as usize].map(|v| set[v as usize].map(f64::from));
        let uv: [f64; 2] = std::array::from_fn(|k| (0..3).map(|c| corners[c][k] * s.high.weights[c]).sum());
        let gradients = self.high.gradients(s.high.face);
        let normal = self.high.face_normal(s.high.face);
        // A surface seen edge on would have a footprint without end: 1/16 is the least cosine.
        let facing = s.direction.dot(normal);
        let facing = facing.abs().max(1.0 / 16.0).copysign(facing);
        let steps = self.steps(s.low).map(|step| {
            let moved = step - s.direction * (step.dot(normal) / facing);
            let weights = gradients.map(|g| g.dot(moved));
            std::array::from_fn::<f64, 2, _>(|k| (0..3).map(|c| corners[c][k] * weights[c]).sum())
        });
        let rows = paint.transform.map(|row| row.map(f64::from));
        let place = rows.map(|[a, b, c]| a * uv[0] + b * uv[1] + c);
        let [[ux, vx], [uy, vy]] = steps;
        let jacobian = rows.map(|[a, b, _]| [a * ux + b * vx, a * uy + b * vy]);
        (place, [jacobian[0][0], jacobian[0][1], jacobian[1][0], jacobian[1][1]])
    }

    /// How the place on the low mesh moves from one sample point to the next, right and down.
    fn steps(&self, at: Place) -> [DVec3; 2] {
        let slopes = self.chart.slopes(at.face);
        let per_axis = (self.samples_per_texel() as f64).sqrt();
        [0, 1].map(|axis| {
            let weights = [0, 1, 2].map(|c| slopes[c][axis] / per_axis);
            self.low.point(Place { face: at.face, weights })
        })
    }
}

fn narrow(v: DVec3) -> [f32; 4] {
    let [x, y, z] = v.as_vec3().to_array();
    [x, y, z, 0.0]
}

/// A number in [0, 1) from a texel: Steele, Lea and Flood's mixer of SplitMix64, OOPSLA 2014.
fn hash([x, y]: [usize; 2], axis: u64) -> f64 {
    let mut z = (x as u64) << 33 ^ (y as u64) << 1 ^ axis;
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}
