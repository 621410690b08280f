// Spheres, each as a rectangle on the screen that contains it: a pixel's fragment is where the ray
// through its centre first hits. Follows frame.wgsl and the constant PERSPECTIVE. The CPU twin is
// `SphereView` in spheres.rs.

// Programs that draw the same spheres must agree on their fragments.
const EXACT_ARITHMETIC = true;

// Where the camera is the origin, x points to the right, y up and z along the line of sight.
struct SphereView {
    // A pixel's ray goes through (px * scale + offset, 1): at distance 1 in a perspective, else
    // everywhere.
    scale: vec2<f32>,
    offset: vec2<f32>,
    near: f32,
    far: f32,
    // Depth is (t * depth.x + depth.y) / t in a perspective, else t * depth.x + depth.y.
    depth: vec2<f32>,
    light: vec3<f32>,
    stripe_offset: f32,
    stripes: vec3<f32>,
}

@group(0) @binding(16) var<uniform> sphere_view: SphereView;
// Centre and radius.
@group(0) @binding(17) var<storage, read> spheres: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read> sphere_rgba: array<u32>;

struct Varyings {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) sphere: vec4<f32>,
    @location(1) @interpolate(flat) rgba: u32,
}

// The least and the greatest x (or y) over z at which a sphere is seen between the planes.
fn extent(across: f32, along: f32, radius: f32) -> vec2<f32> {
    if (!PERSPECTIVE) {
        return vec2<f32>(across - radius, across + radius);
    }
    if (along - radius > sphere_view.near) {
        let beside = (along - radius) * (along + radius);
        let root = radius * sqrt(across * across + beside);
        return vec2<f32>(across * along - root, across * along + root) / beside;
    }
    // It reaches through the near plane: the box about what is behind that.
    let low = across - radius;
    let high = across + radius;
    let last = along + radius;
    return vec2<f32>(
        low / select(last, sphere_view.near, low < 0.0),
        high / select(sphere_view.near, last, high < 0.0),
    );
}

// In pixels, a little more than what is seen: the rasteriser snaps corners to 256ths of a pixel.
fn widened(one: f32, other: f32, size: u32) -> vec2<f32> {
    let low = min(one, other);
    let high = max(one, other);
    let margin = 0.0625 + (high - low) / 512.0;
    return clamp(vec2<f32>(low - margin, high + margin), vec2<f32>(0.0), vec2<f32>(f32(size)));
}

@vertex
fn vs(@builtin(vertex_index) i: u32) -> Varyings {
    let sphere = spheres[i / 6u];
    let in_range =
        sphere.z + sphere.w > sphere_view.near && sphere.z - sphere.w <= sphere_view.far;
    var at = vec2<f32>();
    if (in_range) {
        let x = (extent(sphere.x, sphere.z, sphere.w) - sphere_view.offset.x) / sphere_view.scale.x;
        let y = (extent(sphere.y, sphere.z, sphere.w) - sphere_view.offset.y) / sphere_view.scale.y;
        let columns = widened(x.x, x.y, frame.width_px);
        let rows = widened(y.x, y.y, frame.height_px);
        // Corners 0, 1, 2 and 3, 2, 1 of four.
        let k = i % 6u;
        let corner = select(6u - k, k, k < 3u);
        at.x = select(columns.x, columns.y, (corner & 1u) != 0u);
        at.y = select(rows.x, rows.y, (corner & 2u) != 0u);
    }
    let across = at / vec2<f32>(f32(frame.width_px), f32(frame.height_px));
    let position = vec4<f32>(across.x * 2.0 - 1.0, 1.0 - across.y * 2.0, 0.5, 1.0);
    return Varyings(position, sphere, sphere_rgba[i / 6u]);
}

fn sphere_ray(in: Varyings) -> vec2<f32> {
    return in.position.xy * sphere_view.scale + sphere_view.offset;
}

// A ray meets a sphere where t * square is along - root and along + root; discriminant is root's square.
struct Meeting {
    square: f32,
    along: f32,
    discriminant: f32,
}

fn meeting(in: Varyings) -> Meeting {
    let ray = sphere_ray(in);
    let c = in.sphere.xyz;
    let r = in.sphere.w;
    if (PERSPECTIVE) {
        // The cross product of centre and direction, not a difference of large squares.
        let x = c.y - c.z * ray.y;
        let y = c.z * ray.x - c.x;
        let z = c.x * ray.y - c.y * ray.x;
        let square = (ray.x * ray.x + ray.y * ray.y) + 1.0;
        let along = (c.x * ray.x + c.y * ray.y) + c.z;
        return Meeting(square, along, square * (r * r) - ((x * x + y * y) + z * z));
    }
    let x = c.x - ray.x;
    let y = c.y - ray.y;
    return Meeting(1.0, c.z, r * r - (x * x + y * y));
}

// Whether the ray first hits the sphere between the planes, decided by sums and products alone: these
// are the same on every device.
fn covered(in: Varyings) -> bool {
    let m = meeting(in);
    let near = m.along - m.square * sphere_view.near;
    let far = m.along - m.square * sphere_view.far;
    let behind_near = near >= 0.0 && near * near >= m.discriminant;
    let before_far = far <= 0.0 || far * far <= m.discriminant;
    return m.discriminant >= 0.0 && behind_near && before_far;
}

fn discard_uncovered(in: Varyings) {
    if (!covered(in)) {
        discard;
    }
}

// How far along the line of sight the ray first hits.
fn sphere_hit(in: Varyings) -> f32 {
    let m = meeting(in);
    return (m.along - sqrt(max(m.discriminant, 0.0))) / m.square;
}

fn fragment_depth(in: Varyings) -> f32 {
    let t = sphere_hit(in);
    var depth = t * sphere_view.depth.x + sphere_view.depth.y;
    if (PERSPECTIVE) {
        depth /= t;
    }
    return clamp(depth, 0.0, 1.0);
}

// Two-sided Lambert, as in scene.wgsl, where the camera is the origin.
fn shade(in: Varyings) -> u32 {
    let ray = sphere_ray(in);
    let t = sphere_hit(in);
    var at = vec3<f32>(ray, t);
    if (PERSPECTIVE) {
        at = vec3<f32>(ray * t, t);
    }
    var rgba = unpack4x8unorm(in.rgba);
    if (frame.striped != 0u
        && fract(dot(at, sphere_view.stripes) + sphere_view.stripe_offset) < 0.5) {
        rgba = frame.stripe_rgba;
    }
    let normal = at - in.sphere.xyz;
    let cosine = abs(dot(normal, sphere_view.light)) / max(length(normal), 1e-20);
    let light = frame.ambient + (1.0 - frame.ambient) * cosine;
    return pack4x8unorm(vec4<f32>(rgba.rgb * light, rgba.a));
}
