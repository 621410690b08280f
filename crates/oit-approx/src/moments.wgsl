// Follows scene_wgsl and the constant ROOTS: half as many as there are moments. The CPU twin is
// hamburger.rs, step for step.

// The farthest a root is looked for: what lies beyond has next to no weight.
const FAR = 1000.0;
// The least a pivot may be: rounding can take it below zero.
const PIVOT = 1e-8;
// The most an entry below the diagonal may be. Those of depths from -1 to 1 are smaller: a power of
// depth has these coefficients in polynomials whose recurrence has none above 1.
const LOWER = 100.0;
// The paper's share of what lies at the depth itself that counts as before it.
const OVERESTIMATION = 0.25;

struct Pivots {
    lower: array<array<f32, ROOTS + 1>, ROOTS + 1>,
    diagonal: array<f32, ROOTS + 1>,
}

// The Hankel matrix of the moments as lower triangle, diagonal, upper triangle.
fn factorized(b: array<f32, 2 * ROOTS + 1>) -> Pivots {
    var moments = b;
    var p: Pivots;
    for (var i = 0; i <= ROOTS; i += 1) {
        for (var j = 0; j <= i; j += 1) {
            var sum = moments[i + j];
            for (var k = 0; k < j; k += 1) {
                sum -= p.lower[i][k] * p.lower[j][k] * p.diagonal[k];
            }
            if (j < i) {
                p.lower[i][j] = clamp(sum / p.diagonal[j], -LOWER, LOWER);
            } else {
                p.diagonal[i] = max(sum, PIVOT);
            }
        }
    }
    return p;
}

// The powers of a depth, solved for the lower triangle.
fn forward(p: ptr<function, Pivots>, z: f32) -> array<f32, ROOTS + 1> {
    var c: array<f32, ROOTS + 1>;
    var power = 1.0;
    for (var i = 0; i <= ROOTS; i += 1) {
        var sum = power;
        for (var k = 0; k < i; k += 1) {
            sum -= (*p).lower[i][k] * c[k];
        }
        c[i] = sum;
        power *= z;
    }
    return c;
}

// What of the absorbance lies at a point of the representation: no differences of points are divided
// by.
fn weight(p: ptr<function, Pivots>, z: f32) -> f32 {
    var c = forward(p, z);
    var sum = 0.0;
    for (var i = 0; i <= ROOTS; i += 1) {
        sum += c[i] * c[i] / (*p).diagonal[i];
    }
    return 1.0 / sum;
}

// The other points of the representation that has one at z: roots of a polynomial, all of them real.
fn others(p: ptr<function, Pivots>, z: f32) -> array<f32, ROOTS> {
    var c = forward(p, z);
    var largest = 1e-30;
    for (var i = ROOTS; i >= 0; i -= 1) {
        var sum = c[i] / (*p).diagonal[i];
        for (var k = i + 1; k <= ROOTS; k += 1) {
            sum -= (*p).lower[k][i] * c[k];
        }
        c[i] = sum;
        largest = max(largest, abs(sum));
    }
    for (var i = 0; i <= ROOTS; i += 1) {
        c[i] /= largest;
    }
    var found: array<f32, ROOTS>;
    for (var degree = ROOTS; degree > 2; degree -= 1) {
        // Laguerre's method.
        let n = f32(degree);
        var x = 0.0;
        for (var step = 0; step < LAGUERRE; step += 1) {
            var value = c[degree];
            var slope = 0.0;
            var bend = 0.0;
            for (var k = degree - 1; k >= 0; k -= 1) {
                bend = bend * x + slope;
                slope = slope * x + value;
                value = value * x + c[k];
            }
            let inside = (n - 1.0) * ((n - 1.0) * slope * slope - 2.0 * n * value * bend);
            let root = sqrt(max(inside, 0.0));
            let below = slope + select(-root, root, slope >= 0.0);
            if (below != 0.0) {
                x = clamp(x - n * value / below, -FAR, FAR);
            }
        }
        found[degree - 1] = x;
        // What is left of the polynomial without this root.
        var rest = c[degree];
        for (var k = degree - 1; k >= 0; k -= 1) {
            let own = c[k];
            c[k] = rest;
            rest = own + x * rest;
        }
    }
    let root = sqrt(max(c[1] * c[1] - 4.0 * c[2] * c[0], 0.0));
    let q = -0.5 * (c[1] + select(-root, root, c[1] >= 0.0));
    var ends = vec2<f32>(FAR, 0.0);
    if (abs(q) < FAR * abs(c[2])) {
        ends.x = q / c[2];
    }
    if (q != 0.0) {
        ends.y = clamp(c[0] / q, -FAR, FAR);
    }
    found[0] = ends.x;
    found[1] = ends.y;
    return found;
}

// What of the light from this depth comes through, of moments divided by the absorbance and biased.
fn reconstructed(absorbance: f32, b: array<f32, 2 * ROOTS + 1>, z: f32) -> f32 {
    var p = factorized(b);
    let own = weight(&p, z);
    var before = OVERESTIMATION * own;
    var all = own;
    var points = others(&p, z);
    for (var i = 0; i < ROOTS; i += 1) {
        let share = weight(&p, points[i]);
        all += share;
        if (points[i] < z) {
            before += share;
        }
    }
    return exp(-absorbance * before / all);
}
