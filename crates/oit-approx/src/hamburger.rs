//! The twin of `moments.wgsl`: what the moments of a distribution say of how much of it lies before a
//! point (the truncated Hamburger moment problem).

/// The farthest a root is looked for: what lies beyond has next to no weight.
const FAR: f32 = 1000.0;

/// The least a pivot may be: rounding can take it below zero.
const PIVOT: f32 = 1e-8;

/// The most an entry below the diagonal may be. Those of depths from -1 to 1 are smaller: a power of
/// depth has these coefficients in polynomials whose recurrence has none above 1.
const LOWER: f32 = 100.0;

/// The paper's share of what lies at the depth itself that counts as before it.
const OVERESTIMATION: f32 = 0.25;

/// Steps of Laguerre's method; of no use to four moments, whose polynomial is of degree two.
pub(crate) const LAGUERRE: usize = 6;

/// The most roots: of eight moments.
const MOST: usize = 4;

/// The Hankel matrix of moments as lower triangle, diagonal, upper triangle.
struct Pivots {
    roots: usize,
    lower: [[f32; MOST + 1]; MOST + 1],
    diagonal: [f32; MOST + 1],
}

impl Pivots {
    /// Of the moments 0 to twice the number of roots, the first of them 1.
    fn new(moments: &[f32]) -> Self {
        let roots = moments.len() / 2;
        let (mut lower, mut diagonal) = ([[0.0f32; MOST + 1]; MOST + 1], [0.0f32; MOST + 1]);
        for i in 0..=roots {
            for j in 0..=i {
                let mut sum = moments[i + j];
                for k in 0..j {
                    sum -= lower[i][k] * lower[j][k] * diagonal[k];
                }
                if j < i {
                    lower[i][j] = (sum / diagonal[j]).clamp(-LOWER, LOWER);
                } else {
                    diagonal[i] = sum.max(PIVOT);
                }
            }
        }
        Self { roots, lower, diagonal }
    }

    /// The powers of a depth, solved for the lower triangle.
    fn forward(&self, z: f32) -> [f32; MOST + 1] {
        let mut c = [0.0; MOST + 1];
        let mut power = 1.0;
        for i in 0..=self.roots {
            let mut sum = power;
            for (lower, c) in self.lower[i][..i].iter().zip(&c) {
                sum -= lower * c;
            }
            c[i] = sum;
            power *= z;
        }
        c
    }

    /// What lies at a point of the representation: no differences of points are divided by.
    fn weight(&self, z: f32) -> f32 {
        let c = self.forward(z);
        1.0 / (0..=self.roots).map(|i| c[i] * c[i] / self.diagonal[i]).sum::<f32>()
    }

    /// The other points of the representation that has one at z: roots of a polynomial, all of them
    /// real.
    fn others(&self, z: f32) -> [f32; MOST] {
        let mut c = self.forward(z);
        let mut largest = 1e-30f32;
        for i in (0..=self.roots).rev() {
            let mut sum = c[i] / self.diagonal[i];
            for (lower, c) in self.lower[..=self.roots].iter().zip(&c).skip(i + 1) {
                sum -= lower[i] * c;
            }
            c[i] = sum;
            largest = largest.max(sum.abs());
        }
        for c in &mut c {
            *c /= largest;
        }
        let mut found = [0.0; MOST];
        for degree in (3..=self.roots).rev() {
            let x = laguerre(&c[..=degree]);
            found[degree - 1] = x;
            // What is left of the polynomial without this root.
            let mut rest = c[degree];
            for c in c[..degree].iter_mut().rev() {
                let own = std::mem::replace(c, rest);
                rest = own + x * rest;
            }
        }
        let root = (c[1] * c[1] - 4.0 * c[2] * c[0]).max(0.0).sqrt();
        let q = -0.5 * (c[1] + if c[1] >= 0.0 { root } else { -root });
        found[0] = if q.abs() < FAR * c[2].abs() { q / c[2] } else { FAR };
        found[1] = if q == 0.0 { 0.0 } else { (c[0] / q).clamp(-FAR, FAR) };
        found
    }
}

/// A root of a polynomial of which all are real; the constant comes first.
fn laguerre(c: &[f32]) -> f32 {
    let n = (c.len() - 1) as f32;
    let mut x = 0.0f32;
    for _ in 0..LAGUERRE {
        let (mut value, mut slope, mut bend) = (c[c.len() - 1], 0.0f32, 0.0f32);
        for &c in c[..c.len() - 1].iter().rev() {
            bend = bend * x + slope;
            slope = slope * x + value;
            value = value * x + c;
        }
        let inside = (n - 1.0) * ((n - 1.0) * slope * slope - 2.0 * n * value * bend);
        let root = inside.max(0.0).sqrt();
        let below = slope + if slope >= 0.0 { root } else { -root };
        if below != 0.0 {
            x = (x - n * value / below).clamp(-FAR, FAR);
        }
    }
    x
}

/// The share of a distribution that lies before z, of its moments 0 to 4, 6 or 8 (the first is 1): a
/// quarter of what may lie at z, and all that then lies before it.
pub(crate) fn before(moments: &[f32], z: f32) -> f32 {
    let pivots = Pivots::new(moments);
    let own = pivots.weight(z);
    let (mut before, mut all) = (OVERESTIMATION * own, own);
    for &point in &pivots.others(z)[..pivots.roots] {
        let share = pivots.weight(point);
        all += share;
        if point < z {
            before += share;
        }
    }
    before / all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn moments(points: &[(f32, f32)], count: usize) -> Vec<f32> {
        let total: f32 = points.iter().map(|point| point.1).sum();
        let moment =
            |k: i32| points.iter().map(|&(z, weight)| weight * z.powi(k)).sum::<f32>() / total;
        (0..=count as i32).map(moment).collect()
    }

    #[test]
    fn points_and_weights_have_the_moments_they_were_made_of() {
        // An even spread of many points, whose matrices are far from singular.
        let spread: Vec<_> = (0..64).map(|i| (i as f32 / 31.5 - 1.0, 1.0)).collect();
        for count in [4, 6, 8] {
            let given = moments(&spread, count);
            let pivots = Pivots::new(&given);
            for z in [-0.9, -0.41, 0.03, 0.37, 0.8] {
                let mut points = vec![z];
                points.extend_from_slice(&pivots.others(z)[..count / 2]);
                let made: Vec<_> = points.iter().map(|&z| (z, pivots.weight(z))).collect();
                let total: f32 = made.iter().map(|point| point.1).sum();
                assert!((total - 1.0).abs() < 1e-4, "{count} moments at {z}: {total}");
                for (own, given) in moments(&made, count).iter().zip(&given) {
                    assert!((own - given).abs() < 1e-4, "{count} moments at {z}: {own} {given}");
                }
            }
        }
    }

    #[test]
    fn few_points_are_found_again() {
        for count in [4usize, 6, 8] {
            let points: Vec<_> = (0..count / 2).map(|i| (i as f32 * 0.4 - 0.7, 1.0)).collect();
            let given = moments(&points, count);
            for between in 1..points.len() {
                let z = points[between].0 - 0.2;
                let share = before(&given, z);
                let right = between as f32 / points.len() as f32;
                assert!((share - right).abs() < 0.02, "{count} moments at {z}: {share} {right}");
            }
        }
    }

    proptest! {
        #[test]
        fn shares_are_shares_even_of_what_no_distribution_has(
            moments in prop::collection::vec(-1.5f32..=1.5, 8),
            z in -1.0f32..=1.0,
        ) {
            let mut given = vec![1.0];
            given.extend(moments);
            for count in [4, 6, 8] {
                let share = before(&given[..=count], z);
                prop_assert!((0.0..=1.0).contains(&share), "{} of {:?} at {}", share, given, z);
            }
        }

        #[test]
        fn shares_lie_between_nothing_and_all(
            points in prop::collection::vec((-1.0f32..=1.0, 0.004f32..10.0), 1..9),
            z in -1.0f32..=1.0,
            count in prop::sample::select(vec![4usize, 6, 8]),
        ) {
            let given = moments(&points, count);
            for z in [z, points[0].0, -1.0, 0.0, 1.0] {
                let share = before(&given, z);
                prop_assert!((0.0..=1.0).contains(&share), "{} before {}", share, z);
            }
        }
    }
}
