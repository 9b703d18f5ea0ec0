//! Gauss-Legendre rules on the unit interval and on triangles.

/// A point of a triangle, as shares of the two edges that leave its first corner, and its weight. The
/// weights of a rule sum to 1/2, the area of the triangle that the shares draw.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) along: [f64; 2],
    pub(super) weight: f64,
}

impl Node {
    /// The point in the triangle with these corners.
    pub(super) fn inside(&self, [a, b, c]: [[f64; 2]; 3]) -> [f64; 2] {
        let [f, g] = self.along;
        [0, 1].map(|i| a[i] + f * (b[i] - a[i]) + g * (c[i] - a[i]))
    }
}

/// Points and weights of the `n`-point rule on [0, 1]: exact to degree 2n - 1.
///
/// The points are the roots of the Legendre polynomial, by Newton's method from Tricomi's estimate.
pub(super) fn interval(n: usize) -> Vec<(f64, f64)> {
    let count = n as f64;
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut before, mut value) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
                }
                slope = count * (x * value - before) / (x * x - 1.0);
                let step = value / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// A rule on triangles that is exact to the given total degree: the product rule on the square, one side of
/// which is pressed into a corner. That costs one degree: `n` points a side carry 2n - 2.
pub(super) fn triangle(degree: usize) -> Vec<Node> {
    let points = interval(degree.div_ceil(2) + 1);
    let mut nodes = Vec::with_capacity(points.len() * points.len());
    for &(a, wa) in &points {
        for &(b, wb) in &points {
            nodes.push(Node { along: [a * (1.0 - b), a * b], weight: wa * wb * a });
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_powers_up_to_their_degree() {
        for n in 1..=20 {
            let rule = interval(n);
            for power in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                assert!((sum - 1.0 / (power as f64 + 1.0)).abs() < 1e-14, "{n} {power} {sum}");
            }
        }
    }

    /// The integral of a^p b^q over the triangle is p! q! / (p + q + 2)!.
    #[test]
    fn triangles_too() {
        let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        for degree in 0..12 {
            let rule = triangle(degree);
            for p in 0..=degree {
                for q in 0..=degree - p {
                    let sum: f64 = rule
                        .iter()
                        .map(|n| n.weight * n.along[0].powi(p as i32) * n.along[1].powi(q as i32))
                        .sum();
                    let exact = factorial(p) * factorial(q) / factorial(p + q + 2);
                    assert!((sum - exact).abs() < 1e-14, "{degree} {p} {q}");
                }
            }
        }
    }
}
