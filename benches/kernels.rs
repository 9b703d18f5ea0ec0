//! The inner loops one by one, on every instruction set of the machine: `cargo bench --bench kernels [-- word]`.
//!
//! Pictures of 512 squared, which the second level of a cache holds or nearly so; rates are in output pixels. Figures beside
//! other libraries: `benches/peers/run.py`.

use divan::Bencher;
use divan::counter::ItemsCount;
use multum::kernel::plane::Plane;
use multum::kernel::window::{self, Slab, Soft, Spans};
use multum::kernel::{Isa, box_down, prefix, soft_codes, with_isa};
use multum::warp::remap::{Edge, Grid, Interpolation, Job, Map, Outside, Source, interpolate};
use std::hint::black_box;

const SIDE: usize = 512;

fn main() {
    divan::main();
}

/// The sets of this machine, weakest first.
fn sets() -> Vec<Isa> {
    Isa::available()
}

/// Numbers below 1, always the same.
fn noise(count: usize) -> impl Iterator<Item = f64> {
    let mut state = 1u64;
    (0..count).map(move |_| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    })
}

fn bytes(count: usize) -> Vec<u8> {
    noise(count).map(|x| (x * 256.0) as u8).collect()
}

fn singles(count: usize) -> Vec<f32> {
    noise(count).map(|x| x as f32).collect()
}

/// Where a turn by 0.4 about the middle reads.
fn turned() -> (Vec<f32>, Vec<f32>) {
    let (sin, cos) = 0.4f64.sin_cos();
    let middle = SIDE as f64 / 2.0;
    let place = |i: usize| ((i % SIDE) as f64 - middle, (i / SIDE) as f64 - middle);
    let x = (0..SIDE * SIDE).map(|i| (cos * place(i).0 - sin * place(i).1 + middle) as f32);
    let y = (0..SIDE * SIDE).map(|i| (sin * place(i).0 + cos * place(i).1 + middle) as f32);
    (x.collect(), y.collect())
}

fn remap<T: multum::kernel::remap::Sample>(
    bencher: Bencher<'_, '_>,
    isa: Isa,
    data: &[T],
    kind: Interpolation,
) {
    let channels = data.len() / (SIDE * SIDE);
    let border = vec![T::default(); channels];
    let job = Source::new(data, SIDE, SIDE, channels, SIDE * channels)
        .and_then(|source| Job::new(source, kind, [Edge::Border; 2], &border, Outside::Colour))
        .expect("fits");
    let (x, y) = turned();
    let mut out = vec![T::default(); data.len()];
    bencher.counter(ItemsCount::new(SIDE * SIDE)).bench_local(|| {
        let map = Map::Single(&x, &y);
        with_isa(isa, || interpolate(&job, &map, Grid::Exact, SIDE, black_box(&mut out)))
    });
}

#[divan::bench(args = sets(), consts = [1, 3, 4])]
fn bilinear_bytes<const C: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    remap(bencher, *isa, &bytes(SIDE * SIDE * C), Interpolation::Bilinear);
}

#[divan::bench(args = sets(), consts = [1, 3, 4])]
fn bilinear_words<const C: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    let words: Vec<u16> = noise(SIDE * SIDE * C).map(|x| (x * 65_536.0) as u16).collect();
    remap(bencher, *isa, &words, Interpolation::Bilinear);
}

#[divan::bench(args = sets(), consts = [1, 3, 4])]
fn bilinear_singles<const C: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    remap(bencher, *isa, &singles(SIDE * SIDE * C), Interpolation::Bilinear);
}

#[divan::bench(args = sets())]
fn bicubic_bytes(bencher: Bencher<'_, '_>, isa: &Isa) {
    remap(bencher, *isa, &bytes(SIDE * SIDE * 3), Interpolation::Bicubic(-0.75));
}

#[divan::bench(args = sets())]
fn lanczos_bytes(bencher: Bencher<'_, '_>, isa: &Isa) {
    remap(bencher, *isa, &bytes(SIDE * SIDE * 3), Interpolation::Lanczos4);
}

#[divan::bench(args = sets())]
fn nearest_bytes(bencher: Bencher<'_, '_>, isa: &Isa) {
    remap(bencher, *isa, &bytes(SIDE * SIDE * 3), Interpolation::Nearest);
}

/// Half of a picture, code by code.
#[divan::bench(args = sets())]
fn halve_codes(bencher: Bencher<'_, '_>, isa: &Isa) {
    let data = bytes(2 * SIDE * 3);
    let (a, b) = data.split_at(SIDE * 3);
    let mut out = vec![0; SIDE / 2 * 3];
    bencher
        .counter(ItemsCount::new(SIDE / 2))
        .bench_local(|| box_down::halve_codes(*isa, black_box(a), black_box(b), 3, black_box(&mut out)));
}

/// A row of a summed-area table.
#[divan::bench(args = sets(), consts = [1, 3, 4])]
fn prefix_bytes<const C: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    let texels = bytes(SIDE * C);
    let (above, mut out) = (vec![7u32; (SIDE + 1) * C], vec![0u32; (SIDE + 1) * C]);
    bencher
        .counter(ItemsCount::new(SIDE))
        .bench_local(|| prefix::row(*isa, black_box(&texels), &[0; C], &above, black_box(&mut out)));
}

/// Footprints of this many texels a side, turned by 0.4.
fn footprint(side: f64) -> Soft {
    let (sin, cos) = 0.4f64.sin_cos();
    let sides = [[side * cos, side * sin], [-side * sin, side * cos]];
    Soft { centre: [200.3, 200.6], ..Soft::new(sides, [side; 2], side * side, 1.0) }
}

/// Nothing lies beyond the picture here.
struct Nothing;

impl soft_codes::Texels for Nothing {
    fn eight(&self, _x: i32, _y: i32, _texels: &mut [u8; soft_codes::READ]) {}
}

#[divan::bench(args = sets(), consts = [2, 4, 8, 16])]
fn soft_bytes<const N: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    let data = bytes(SIDE * SIDE * 4);
    let last = SIDE as i32 - 1;
    let plane = Plane {
        data: &data,
        origin: 0,
        row: 4 * SIDE,
        lanes: 4,
        channels: 4,
        width: SIDE as i32,
        height: SIDE as i32,
        columns: (0, last),
        rows: (0, last),
    };
    let footprint = footprint(N as f64);
    bencher
        .counter(ItemsCount::new(1usize))
        .bench_local(|| soft_codes::soft(*isa, black_box(&footprint), &plane, &Nothing));
}

/// A picture of singles, four channels.
struct Picture<'a>(&'a [f32]);

impl window::Source for Picture<'_> {
    const FLOAT: bool = false;
    #[inline(always)]
    fn chunk<L: multum::kernel::lanes::Lanes>(&mut self, row: i64, first: i64) -> [L; 4] {
        let start = 4 * (row as usize * SIDE + first as usize);
        let (eights, _) = self.0[start..start + 32].as_chunks::<8>();
        [L::load(&eights[0]), L::load(&eights[1]), L::load(&eights[2]), L::load(&eights[3])]
    }
}

#[divan::bench(args = sets(), consts = [2, 4, 8, 16])]
fn soft_singles<const N: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    let data = singles(SIDE * SIDE * 4);
    let footprint = footprint(N as f64);
    bencher
        .counter(ItemsCount::new(1usize))
        .bench_local(|| window::soft(*isa, black_box(&footprint), Picture(&data)));
}

#[divan::bench(args = sets(), consts = [2, 4, 8, 16])]
fn spans_singles<const N: usize>(bencher: Bencher<'_, '_>, isa: &Isa) {
    let data = singles(SIDE * SIDE * 4);
    let half = N as f64 / 2.0;
    let slabs = [
        Slab { y: [-half, 0.0], left: [0.0, -half], right: [0.0, half] },
        Slab { y: [0.0, half], left: [-half, 0.0], right: [half, 0.0] },
    ];
    let spans = Spans { centre: [200.3, 200.6], slabs: &slabs };
    bencher
        .counter(ItemsCount::new(1usize))
        .bench_local(|| window::spans(*isa, black_box(&spans), Picture(&data)));
}
