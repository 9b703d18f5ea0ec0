//! The fuzz targets over their corpus, and over mutations of it that are the same in every run.
#![cfg(all(feature = "image", feature = "mesh"))]

mod fuzzing;

use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

/// Mutations of each file of the corpus.
const MUTATIONS: u64 = 150;
/// The same where a call may average millions of texels, which takes a debug build its time.
const FEW: u64 = 20;

/// A small generator of numbers: splitmix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// What damage does to files: flipped bits, extreme numbers, cuts, repeats, foreign parts.
fn mutated(seed: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut data = seed.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(data.len());
        match random.below(8) {
            0 if !data.is_empty() => data[at] ^= 1 << random.below(8),
            1 if !data.is_empty() => data[at] = random.next() as u8,
            2 => data.truncate(at),
            3 => {
                let extremes = [0, 1, 0x7f, 0xff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7fc0_0000u32];
                let number = extremes[random.below(extremes.len())];
                let bytes = if random.below(2) == 0 { number.to_le_bytes() } else { number.to_be_bytes() };
                for (place, byte) in data.iter_mut().skip(at).zip(bytes) {
                    *place = byte;
                }
            }
            4 => {
                let end = (at + random.below(64)).min(data.len());
                let part = data[at.min(end)..end].to_vec();
                data.splice(at..at, part);
            }
            5 => {
                let end = (at + random.below(16)).min(data.len());
                data.drain(at.min(end)..end);
            }
            6 => {
                let from = random.below(other.len());
                let end = (from + random.below(64)).min(other.len());
                data.splice(at..at, other[from..end].iter().copied());
            }
            _ => {
                // A digit of a text, or of a number in it.
                if let Some(place) = data.iter_mut().skip(at).find(|b| b.is_ascii_digit()) {
                    *place = b"0123456789-e."[random.below(13)];
                }
            }
        }
    }
    data
}

fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{} is empty", folder.display());
    paths.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

fn run(target: &str, mutations: u64, call: fn(&[u8])) {
    let seeds = corpus(target);
    let fail = |path: &Path, data: &[u8]| {
        let input = std::env::temp_dir().join(format!("multum-fuzz-{target}"));
        fs::write(&input, data).unwrap();
        panic!("{target} panics on a mutation of {}; the input is in {}", path.display(), input.display());
    };
    let mut random = Random(20);
    for (path, seed) in &seeds {
        if catch_unwind(|| call(seed)).is_err() {
            fail(path, seed);
        }
        for _ in 0..mutations {
            let other = &seeds[random.below(seeds.len())].1;
            let data = mutated(seed, other, &mut random);
            if catch_unwind(|| call(&data)).is_err() {
                fail(path, &data);
            }
        }
    }
}

#[test]
fn readers_of_images_survive() {
    run("image", MUTATIONS, fuzzing::image);
}

#[test]
fn readers_of_meshes_survive() {
    run("mesh", MUTATIONS, fuzzing::mesh);
}

#[test]
fn wrapping_survives() {
    run("wrap", MUTATIONS, fuzzing::wrap);
}

#[test]
fn sampling_survives() {
    run("sample", FEW, fuzzing::sample);
}

#[test]
fn warping_survives() {
    run("warp", FEW, fuzzing::warps);
}

#[test]
fn the_drop_ins_survive() {
    run("compat", FEW, fuzzing::compat);
}

#[test]
fn the_rasteriser_survives() {
    run("raster", MUTATIONS, fuzzing::raster);
}

/// Images and meshes of the corpus are those that the readers take, else mutations would test the first check
/// alone; but for those named `bad-`, which are refused.
#[test]
fn the_corpus_is_read() {
    let is_bad = |path: &Path| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with("bad-"));
    for (path, data) in corpus("image") {
        assert_eq!(multum::files::decode(&path, &data).is_err(), is_bad(&path), "{}", path.display());
    }
    for (path, data) in corpus("mesh") {
        let read = multum::mesh::Scene::decode(&path, &data, multum::mesh::Normals::Auto);
        assert_eq!(read.is_err(), is_bad(&path), "{}", path.display());
    }
}
