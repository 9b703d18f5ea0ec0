//! Maps from geometry: what a detailed mesh looks like, written into the texture of a simple one.
//!
//! ```text
//!  texel -> sample points -> place on the low mesh -> place on the high mesh -> number -> mean over the texel
//!           cover             surface                 cast, tree               quantity   here, then dilate
//! ```
//!
//! Each texel that a triangle of the low mesh touches in texture space is sampled at a grid of points. From
//! the place on the low mesh a line runs both ways along the cage direction, no further than a stated distance,
//! and meets the high mesh; or the closest point is taken. What is read there is averaged over the samples
//! that found something: vectors as directions, all else as numbers. Texels without an answer get that of the
//! nearest texel with one, so that no filter on any level meets background.
//!
//! Nothing is silent: [`Report`] counts and [`flag`] marks texels without a hit, with several candidates, and
//! with overlapping uv; faces that are mirrored, degenerate or outside; edges that are not manifold.
//!
//! Results do not depend on the number of threads.

mod cast;
mod cover;
mod dilate;
mod layout;
mod quantity;
mod report;
mod surface;
mod tree;
mod triangle;

use crate::encode::{Encoding, encode};
use crate::error::{Error, Result};
use crate::image::{Image, Pixels};
use crate::mesh::Mesh;
use crate::par;
use crate::texel::DType;
use cast::{Caster, Sample};
use cover::{Chart, Piece};
use quantity::Quantity;
use surface::{Place, Surface};

pub use cast::{Hit, closest, intersect};
pub use layout::{Layout, layout};
pub use quantity::{Map, Paint, Space};
pub use report::{Report, flag};

/// Largest number of sample points along the side of a texel.
const MOST_SAMPLES: usize = 8;
/// Largest side of a map.
const MOST_TEXELS: usize = 16384;

/// How a point of the high mesh is found for a point of the low mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Along the cage direction, what is seen from outside: the outermost hit within the distance.
    #[default]
    Outermost,
    /// Along the cage direction, the hit with the shortest way.
    Nearest,
    /// The closest point in space, whatever its direction.
    Closest,
}

impl Method {
    /// All values with their names.
    pub const NAMES: [(&'static str, Self); 3] =
        [("outermost", Self::Outermost), ("nearest", Self::Nearest), ("closest", Self::Closest)];

    /// The value of this name.
    ///
    /// # Errors
    /// [`Error::Value`] for any other word.
    pub fn parse(argument: &'static str, name: &str) -> Result<Self> {
        let found = Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
        found.ok_or_else(|| {
            let expected = "one of \"outermost\", \"nearest\", \"closest\"";
            Error::value(argument, format!("{name:?}"), expected)
        })
    }
}

/// How to bake, each with its default.
#[derive(Clone, Debug)]
pub struct Options {
    /// Sample points along each side of a texel: the square of it in all.
    pub samples: usize,
    /// How points of the high mesh are found.
    pub method: Method,
    /// How far from the low mesh, on both sides, in the meshes' unit; `None` for twice the largest distance of
    /// a vertex of one mesh to the other.
    pub distance: Option<f64>,
    /// Places of the cage's vertices, one a vertex of the low mesh, that tell the direction of the lines;
    /// `None` for smooth normals.
    pub cage: Option<Vec<[f32; 3]>>,
    /// How many texels around the islands are filled; `None` for all.
    pub padding: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Self { samples: 3, method: Method::Outermost, distance: None, cage: None, padding: None }
    }
}

/// A map as numbers: unit vectors, lengths, shares; not yet codes.
#[derive(Clone, Debug)]
pub struct Baked {
    width: usize,
    height: usize,
    channels: usize,
    values: Vec<f32>,
    coverage: Vec<f32>,
    flags: Vec<u8>,
    report: Report,
}

impl Baked {
    /// Width and height in texels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Numbers a texel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The numbers, texel by texel, row by row.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Share of each texel's sample points that lie on the low mesh and found the high mesh.
    pub fn coverage(&self) -> &[f32] {
        &self.coverage
    }

    /// Bits of [`flag`], one byte a texel.
    pub fn flags(&self) -> &[u8] {
        &self.flags
    }

    /// What happened.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The smallest and largest number among texels that found the high mesh; `None` if none did.
    pub fn range(&self) -> Option<[f32; 2]> {
        let found = self.values.chunks_exact(self.channels).zip(&self.flags);
        found.filter(|(_, flags)| **flags & flag::COVERED != 0).flat_map(|(values, _)| values).fold(
            None,
            |range, &x| {
                let [lo, hi] = range.unwrap_or([x, x]);
                Some([lo.min(x), hi.max(x)])
            },
        )
    }

    /// The map as codes of a type. With a `range`, its ends become 0 and full scale first.
    ///
    /// # Errors
    /// [`Error::Value`] for a range that is empty or not finite.
    pub fn image(&self, dtype: DType, encoding: Encoding, range: Option<[f64; 2]>) -> Result<Image> {
        let (offset, scale) = match range {
            None => (0.0, 1.0),
            Some([lo, hi]) if hi > lo && (hi - lo).is_finite() => (lo, 1.0 / (hi - lo)),
            Some(range) => {
                return Err(Error::value(
                    "range",
                    format!("{range:?}"),
                    "two finite numbers, the first smaller",
                ));
            }
        };
        let code = |x: f32| encode(encoding, dtype, (f64::from(x) - offset) * scale);
        let whole = |x: f32, most: f64| (code(x) + 0.5).floor().clamp(0.0, most);
        let values = self.values.iter().copied();
        let pixels: Pixels = match dtype {
            DType::U8 => values.map(|x| whole(x, 255.0) as u8).collect::<Vec<_>>().into(),
            DType::U16 => values.map(|x| whole(x, 65535.0) as u16).collect::<Vec<_>>().into(),
            DType::F32 => values.map(|x| code(x) as f32).collect::<Vec<_>>().into(),
            other => return Err(Error::type_("dtype", other.name(), "uint8, uint16 or float32")),
        };
        Image::new(self.width, self.height, self.channels, pixels)
    }
}

/// What a tile of texels came to.
#[derive(Default)]
struct Tile {
    values: Vec<[f32; 4]>,
    coverage: Vec<f32>,
    flags: Vec<u8>,
    rays: u64,
}

/// Bakes a map of `size` = (width, height) texels for the low mesh's first uv set.
///
/// # Errors
/// [`Error::Value`] when a mesh is not what [`Mesh::check`] asks for, the low mesh has no uv, or an option is
/// out of its range; [`Error::Interrupted`].
///
/// ```
/// use multum::bake::{Map, Options, Space, bake};
/// use multum::mesh::Mesh;
/// // A square seen from above, baked from itself: the normal is +z everywhere.
/// let mut square = Mesh {
///     positions: vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
///     normals: vec![[0., 0., 1.]; 4],
///     tangents: vec![[1., 0., 0., 1.]; 4],
///     uv: vec![vec![[0., 1.], [1., 1.], [1., 0.], [0., 0.]]],
///     faces: vec![[0, 1, 2], [0, 2, 3]],
///     face_material: vec![0, 0],
///     materials: vec![Default::default()],
///     ..Mesh::default()
/// };
/// let baked = bake(&square, &square, &Map::Normal(Space::Tangent), [4, 4], &Options::default())?;
/// assert!(baked.values().chunks(3).all(|n| n == [0.0, 0.0, 1.0]));
/// assert_eq!(baked.report().covered, 16);
/// # Ok::<(), multum::Error>(())
/// ```
pub fn bake(high: &Mesh, low: &Mesh, map: &Map<'_>, size: [usize; 2], options: &Options) -> Result<Baked> {
    check(high, low, size, options)?;
    let uv = low.uv.first().ok_or_else(|| Error::value("low", "a mesh without uv", "one with a uv set"))?;
    let chart = Chart::new(uv, &low.faces, size, options.samples)?;
    let (high, low) = (Surface::new(high), Surface::new(low));
    let caster = Caster::new(&high, &low, options)?;
    let quantity = Quantity::new(map, &high, &low, &chart, &caster)?;
    let [tiles_x, tiles_y] = chart.tiles();
    let mut tiles: Vec<Tile> = (0..tiles_x * tiles_y).map(|_| Tile::default()).collect();
    par::for_each(tiles.iter_mut(), |i, tile| {
        let place = [i % tiles_x, i / tiles_x];
        if let Some(pieces) = chart.pieces(place) {
            let [[x0, x1], [y0, _]] = chart.texels(place);
            *tile = fill(&pieces, &caster, &quantity, |k| [x0 + k % (x1 - x0), y0 + k / (x1 - x0)])?;
        }
        Ok(())
    })?;
    let report = Report {
        texels: size[0] * size[1],
        distance: caster.distance(),
        mirrored_faces: chart.mirrored_faces,
        degenerate_faces: chart.degenerate_faces,
        outside_faces: chart.outside_faces,
        non_manifold_edges: [high.non_manifold_edges(), low.non_manifold_edges()],
        ..Report::default()
    };
    gather(&chart, tiles, size, quantity.channels(), quantity.background(), report, options.padding)
}

fn check_grid(size: [usize; 2], samples: usize) -> Result<()> {
    if size.iter().any(|n| !(1..=MOST_TEXELS).contains(n)) {
        return Err(Error::value("size", format!("{size:?}"), format!("1 to {MOST_TEXELS} texels a side")));
    }
    if !(1..=MOST_SAMPLES).contains(&samples) {
        return Err(Error::value("samples", samples, format!("1 to {MOST_SAMPLES}")));
    }
    Ok(())
}

fn check(high: &Mesh, low: &Mesh, size: [usize; 2], options: &Options) -> Result<()> {
    high.check()?;
    low.check()?;
    check_grid(size, options.samples)?;
    if let Some(distance) = options.distance.filter(|d| !(*d > 0.0 && d.is_finite())) {
        return Err(Error::value("distance", distance, "None or a positive number"));
    }
    if let Some(cage) = &options.cage {
        if cage.len() != low.positions.len() {
            let expected = format!("one a vertex of the low mesh, {}", low.positions.len());
            return Err(Error::value("cage", format!("{} places", cage.len()), expected));
        }
        if !cage.as_flattened().iter().all(|c| c.is_finite()) {
            return Err(Error::value("cage", "a number that is not finite", "finite numbers"));
        }
    }
    Ok(())
}

/// Casts the samples of a tile, reads the map's quantity and averages it by texel.
fn fill(
    pieces: &[Piece],
    caster: &Caster<'_>,
    quantity: &Quantity<'_>,
    texel: impl Fn(usize) -> [usize; 2],
) -> Result<Tile> {
    let mut stack = Vec::new();
    let mut samples: Vec<Sample> = Vec::new();
    let mut owners = Vec::new();
    let mut flags = vec![0u8; pieces.len()];
    let mut misses = vec![0usize; pieces.len()];
    let mut tile = Tile::default();
    for (k, piece) in pieces.iter().enumerate() {
        flags[k] |= if piece.overlapping { flag::OVERLAPPING } else { 0 };
        for &(face, weights) in &piece.samples {
            tile.rays += 1;
            match caster.cast(&mut stack, Place { face, weights }) {
                Some((sample, ambiguous)) => {
                    flags[k] |= if ambiguous { flag::AMBIGUOUS } else { 0 };
                    owners.push(k);
                    samples.push(sample);
                }
                None => misses[k] += 1,
            }
        }
    }
    let values = quantity.values(&samples, &mut stack, |i| texel(owners[i]))?;
    let mut sums = vec![[0.0f64; 4]; pieces.len()];
    let mut counts = vec![0usize; pieces.len()];
    let mut firsts = vec![[0.0f32; 4]; pieces.len()];
    for (&owner, value) in owners.iter().zip(&values) {
        if counts[owner] == 0 {
            firsts[owner] = *value;
        }
        counts[owner] += 1;
        sums[owner].iter_mut().zip(value).for_each(|(sum, &x)| *sum += f64::from(x));
    }
    for (k, piece) in pieces.iter().enumerate() {
        let found = counts[k] > 0;
        flags[k] |= match (found, misses[k] > 0) {
            (true, false) => flag::COVERED,
            (true, true) => flag::COVERED | flag::PARTLY_MISSED,
            (false, true) => flag::MISSED,
            (false, false) => 0,
        };
        // The piece between the sample points of a sliver stands for less than one of them.
        let share = if piece.sliver { 0.0 } else { counts[k] as f32 };
        tile.coverage.push(share / quantity.samples_per_texel() as f32);
        tile.values.push(if found { quantity.mean(sums[k], counts[k], firsts[k]) } else { [0.0; 4] });
    }
    tile.flags = flags;
    Ok(tile)
}

/// Tiles to a picture, and the picture's empty texels filled.
fn gather(
    chart: &Chart,
    tiles: Vec<Tile>,
    [width, height]: [usize; 2],
    channels: usize,
    background: [f32; 4],
    mut report: Report,
    padding: Option<usize>,
) -> Result<Baked> {
    let mut values = vec![0.0f32; width * height * channels];
    let mut coverage = vec![0.0f32; width * height];
    let mut flags = vec![0u8; width * height];
    let tiles_x = chart.tiles()[0];
    for (i, tile) in tiles.into_iter().enumerate() {
        report.rays += tile.rays;
        let [[x0, x1], [y0, _]] = chart.texels([i % tiles_x, i / tiles_x]);
        for (k, (value, (share, bits))) in
            tile.values.into_iter().zip(tile.coverage.into_iter().zip(tile.flags)).enumerate()
        {
            let texel = (y0 + k / (x1 - x0)) * width + x0 + k % (x1 - x0);
            values[texel * channels..][..channels].copy_from_slice(&value[..channels]);
            coverage[texel] = share;
            flags[texel] = bits;
        }
    }
    report.count(&flags);
    let covered = |i: usize| flags[i] & flag::COVERED != 0;
    let reach = padding.map_or(f64::INFINITY, |texels| texels as f64);
    let sources = dilate::nearest(&covered, width, height, reach)?;
    for (texel, source) in sources.into_iter().enumerate() {
        match source {
            Some(source) if source == texel => {}
            Some(source) => values.copy_within(source * channels..(source + 1) * channels, texel * channels),
            None => values[texel * channels..][..channels].copy_from_slice(&background[..channels]),
        }
    }
    Ok(Baked { width, height, channels, values, coverage, flags, report })
}
