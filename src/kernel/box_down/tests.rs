use super::*;

fn light(code: f64) -> f64 {
    let s = code / 255.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

fn noise(count: usize) -> Vec<u8> {
    (0..count as u64).map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) as u8).collect()
}

/// Every single in the table's range, by its steps and their neighbours.
#[test]
fn codes_are_the_nearest_at_every_step() {
    let srgb = SrgbBytes::new(light);
    for code in 0..255u32 {
        let exact = light(f64::from(code) + 0.5);
        let mut x = exact as f32;
        for _ in 0..3 {
            x = x.next_down();
        }
        for _ in 0..7 {
            let want = if f64::from(x) >= exact { code + 1 } else { code };
            assert_eq!(u32::from(scalar::nearest(x, &srgb.codes)), want, "{x}");
            x = x.next_up();
        }
    }
    for code in 0..=255u8 {
        let x = srgb.light[usize::from(code)] as f32 / 16_777_216.0;
        assert_eq!(scalar::nearest(x, &srgb.codes), code, "round trip");
    }
    for (x, code) in [(-1.0, 0), (f32::NAN, 0), (0.0, 0), (2.0, 255), (f32::INFINITY, 255), (1e-30, 0)] {
        assert_eq!(scalar::nearest(x, &srgb.codes), code);
    }
}

#[test]
fn bytes_are_equal_on_every_instruction_set() {
    let srgb = SrgbBytes::new(light);
    for channels in 1..=6usize {
        for width in [1usize, 2, 5, 8, 9, 16, 31, 67] {
            let (a, b) = (noise(2 * width * channels), noise(2 * width * channels + 9)[9..].to_vec());
            let numbers =
                |codes: &[u8]| codes.iter().map(|&c| f32::from(c) / 77.0 - 0.5).collect::<Vec<f32>>();
            let (fa, fb) = (numbers(&a), numbers(&b));
            let mut special = fa.clone();
            for (i, x) in [f32::NAN, f32::INFINITY, -f32::INFINITY, -0.0, 254.5, 1e-40].iter().enumerate() {
                let at = (i * 7) % special.len();
                special[at] = *x;
            }
            let out = width * channels;
            let run = |isa: Isa| {
                let mut floats = vec![vec![0f32; out]; 6];
                halve_both(isa, &fa, &fb, channels, &mut floats[0]);
                halve_columns(isa, &fa, channels, &mut floats[1]);
                halve_bytes(isa, &a, &b, channels, &mut floats[2]);
                halve_srgb(isa, [&a, &b], channels, false, &srgb, &mut floats[3]);
                if channels > 1 {
                    halve_srgb(isa, [&a, &b], channels, true, &srgb, &mut floats[4]);
                }
                halve_rows(isa, &fa, &fb, &mut floats[5]);
                let mut codes = vec![vec![0u8; special.len()]; 5];
                halve_codes(isa, &a, &b, channels, &mut codes[4][..out]);
                to_bytes(isa, &special, &mut codes[0]);
                to_srgb(isa, &special, channels, false, &srgb, &mut codes[1]);
                if channels > 1 {
                    to_srgb(isa, &special, channels, true, &srgb, &mut codes[2]);
                }
                to_srgb(isa, &floats[3], channels, false, &srgb, &mut codes[3][..out]);
                let bits: Vec<Vec<u32>> =
                    floats.iter().map(|f| f.iter().map(|x| x.to_bits()).collect()).collect();
                (bits, codes)
            };
            let want = run(Isa::Scalar);
            for isa in Isa::available() {
                assert_eq!(run(isa), want, "{isa:?} {channels} {width}");
            }
        }
    }
}
