// Packed formats.

// Directions within a face: the face's axis and its two in-plane axes.
fn axis_u(axis: u32) -> u32 { return select(axis + 1u, 0u, axis == 2u); }
fn axis_v(axis: u32) -> u32 { return select(axis - 1u, 2u, axis == 0u); }

fn side_normal(side: u32) -> vec3<f32> {
    let axis = side >> 1u;
    let sign = select(-1.0, 1.0, (side & 1u) == 1u);
    return sign * vec3<f32>(f32(axis == 0u), f32(axis == 1u), f32(axis == 2u));
}

// Shared-exponent RGB (EXT_texture_shared_exponent). `rounding` is 0.5 for nearest, or uniform in [0, 1) per channel.
fn rgb9e5_encode(color: vec3<f32>, rounding: vec3<f32>) -> u32 {
    let c = clamp(color, vec3<f32>(0.0), vec3<f32>(65408.0));
    let largest = max(max(c.x, c.y), c.z);
    if !(largest > 1e-9) { return 0u; }
    var exponent = clamp(i32(bitcast<u32>(largest) >> 23u) - 111, 0, 31);
    let scale = bitcast<f32>(u32(151 - exponent) << 23u);
    var m = vec3<u32>(c * scale + rounding);
    // Rounding up from 511 carries into the exponent: without it a quiet running average cannot cross a power of two.
    if max(max(m.x, m.y), m.z) > 511u && exponent < 31 {
        exponent += 1;
        m = vec3<u32>(c * scale * 0.5 + rounding);
    }
    m = min(m, vec3<u32>(511u));
    return m.x | (m.y << 9u) | (m.z << 18u) | (u32(exponent) << 27u);
}

fn rgb9e5_decode(word: u32) -> vec3<f32> {
    let scale = bitcast<f32>(((word >> 27u) + 103u) << 23u);
    return vec3<f32>(vec3<u32>(word & 511u, (word >> 9u) & 511u, (word >> 18u) & 511u)) * scale;
}

// RGB565 of the square root, dithered in the linear domain so that the mean over faces is exact.
fn albedo_encode(albedo: vec3<f32>, dither: vec3<f32>) -> u32 {
    let levels = vec3<f32>(31.0, 63.0, 31.0);
    let a = clamp(albedo, vec3<f32>(0.0), vec3<f32>(1.0));
    let low = min(floor(sqrt(a) * levels), levels - 1.0);
    let low2 = low / levels;
    let high2 = (low + 1.0) / levels;
    let share = (a - low2 * low2) / (high2 * high2 - low2 * low2);
    let q = vec3<u32>(low + select(vec3<f32>(0.0), vec3<f32>(1.0), share > dither));
    return q.x | (q.y << 5u) | (q.z << 11u);
}

fn albedo_decode(word: u32) -> vec3<f32> {
    let q = vec3<f32>(vec3<u32>(word & 31u, (word >> 5u) & 63u, (word >> 11u) & 31u)) / vec3<f32>(31.0, 63.0, 31.0);
    return q * q;
}

// RGB 11 11 10 of the square root: fine enough to need no dither, so that equal surfaces stay equal.
fn fine_albedo_encode(albedo: vec3<f32>) -> u32 {
    let q = vec3<u32>(round(sqrt(clamp(albedo, vec3<f32>(0.0), vec3<f32>(1.0))) * vec3<f32>(2047.0, 2047.0, 1023.0)));
    return q.x | (q.y << 11u) | (q.z << 22u);
}

fn fine_albedo_decode(word: u32) -> vec3<f32> {
    let q = vec3<f32>(vec3<u32>(word & 2047u, (word >> 11u) & 2047u, word >> 22u)) / vec3<f32>(2047.0, 2047.0, 1023.0);
    return q * q;
}

// A face's plane: n.p = offset in the voxel's unit cube.
struct Plane {
    normal: vec3<f32>,
    offset: f32,
}

const PLANE_NORMAL_STEPS: f32 = 511.0;
const PLANE_OFFSET_STEPS: f32 = 2047.0;
// Half of the cube's diagonal.
const PLANE_OFFSET_RANGE: f32 = 0.87;

// Hemi-octahedral normal about the face's axis (10 + 10 bits, odd grid: the axis is exact), offset about the voxel's
// centre (12 bits), stepped inward when the plane would leave the voxel at `centroid`.
fn plane_encode(side: u32, normal: vec3<f32>, centroid: vec3<f32>) -> u32 {
    let axis = side >> 1u;
    let sign = select(-1.0, 1.0, (side & 1u) == 1u);
    let nu = normal[axis_u(axis)];
    let nv = normal[axis_v(axis)];
    let sum = abs(nu) + abs(nv) + max(normal[axis] * sign, 1e-3);
    let p = u32(round((nu + nv) / sum * PLANE_NORMAL_STEPS) + PLANE_NORMAL_STEPS);
    let q = u32(round((nu - nv) / sum * PLANE_NORMAL_STEPS) + PLANE_NORMAL_STEPS);
    let n = plane_normal(side, p | (q << 10u));
    let exact = dot(n, centroid - 0.5);
    var o = round(exact / PLANE_OFFSET_RANGE * PLANE_OFFSET_STEPS);
    for (var i = 0; i < 2; i++) {
        let x = centroid[axis] + (o * (PLANE_OFFSET_RANGE / PLANE_OFFSET_STEPS) - exact) / n[axis];
        if x > 0.9985 { o -= sign; } else if x < 0.0015 { o += sign; }
    }
    o = clamp(o, -PLANE_OFFSET_STEPS, PLANE_OFFSET_STEPS);
    return p | (q << 10u) | (u32(o + PLANE_OFFSET_STEPS) << 20u);
}

fn plane_normal(side: u32, word: u32) -> vec3<f32> {
    let p = f32(word & 1023u) / PLANE_NORMAL_STEPS - 1.0;
    let q = f32((word >> 10u) & 1023u) / PLANE_NORMAL_STEPS - 1.0;
    let u = (p + q) * 0.5;
    let v = (p - q) * 0.5;
    let a = max(1.0 - abs(u) - abs(v), 0.02) * select(-1.0, 1.0, (side & 1u) == 1u);
    let axis = side >> 1u;
    let local = normalize(vec3<f32>(a, u, v));
    if axis == 0u { return local; }
    if axis == 1u { return local.zxy; }
    return local.yzx;
}

fn plane_decode(side: u32, word: u32) -> Plane {
    let normal = plane_normal(side, word);
    let o = (f32(word >> 20u) - PLANE_OFFSET_STEPS) * (PLANE_OFFSET_RANGE / PLANE_OFFSET_STEPS);
    return Plane(normal, o + 0.5 * (normal.x + normal.y + normal.z));
}

// Bit of the 4 x 4 coverage mask at a point of the voxel's unit cube.
fn mask_bit(axis: u32, p: vec3<f32>) -> u32 {
    let u = u32(clamp(p[axis_u(axis)] * 4.0, 0.0, 3.0));
    let v = u32(clamp(p[axis_v(axis)] * 4.0, 0.0, 3.0));
    return v * 4u + u;
}
