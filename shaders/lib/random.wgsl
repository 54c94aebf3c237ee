// Hashes and low-discrepancy sequences.

// PCG (Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 2020).
fn pcg(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

fn unit_float(hash: u32) -> f32 {
    return f32(hash >> 8u) * (1.0 / 16777216.0);
}

fn hash3(p: vec3<u32>) -> u32 {
    return pcg(p.x + pcg(p.y + pcg(p.z)));
}

// R2 (Roberts 2018), shifted by a seed: point `index` of a sequence that fills the unit square evenly.
fn r2(seed: u32, index: u32) -> vec2<f32> {
    let start = vec2<u32>(pcg(seed), pcg(seed ^ 0x9e3779b9u));
    // Steps of 1/g and 1/g^2 in 32-bit fixed point: exact at any index.
    let fixed = start + vec2<u32>(3242174889u, 2447445414u) * index;
    return vec2<f32>(unit_float(fixed.x), unit_float(fixed.y));
}

// The same in four dimensions: a Kronecker sequence whose steps were searched for so that every pair of coordinates, every
// three and all four fill their space evenly (no two of the first N points, 8 <= N <= 256, nearer than .4 N^(-1/d); xy: .6).
// What one frame decides by several numbers takes them all from one point, so that none beats with another.
fn kronecker4(seed: u32, index: u32) -> vec4<f32> {
    let start = vec4<u32>(pcg(seed), pcg(seed ^ 0x9e3779b9u), pcg(seed ^ 0x7f4a7c15u), pcg(seed ^ 0xf39cc060u));
    let fixed = start + vec4<u32>(1991469039u, 513023621u, 1869738863u, 3893359705u) * index;
    return vec4<f32>(unit_float(fixed.x), unit_float(fixed.y), unit_float(fixed.z), unit_float(fixed.w));
}

// Frame about a normal (Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017).
fn basis(n: vec3<f32>) -> mat3x3<f32> {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return mat3x3<f32>(vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3<f32>(b, s + n.y * n.y * a, -n.y), n);
}

// Cosine-weighted direction about n.
fn cosine_direction(n: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    let r = sqrt(u.x);
    let phi = 6.2831853 * u.y;
    return basis(n) * vec3<f32>(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 1e-6)));
}
