// Where a light is seen from a point, and how strongly: one sample of lights that have an extent.

#import lib/random.wgsl
#import shared/limits.wgsl
#import shared/frame.wgsl

struct LightSample {
    // Towards the light.
    direction: vec3<f32>,
    // How far it is, voxels.
    reach: f32,
    // Irradiance on a plane that faces it, over the light's colour; 0: it is not seen from here.
    strength: f32,
}

// Whether there are lights with an extent. Most scenes have none, and their shader stays small.
const AREAS: bool = false;
const TAU: f32 = 6.2831853;
// Half a brick's diagonal, voxels.
const BRICK_RADIUS: f32 = 6.93;
// Rectangles that are seen smaller than this (steradians) are sampled by area: it makes no difference, and the corners of
// a tiny spherical rectangle are lost in rounding.
const SMALL_ANGLE: f32 = 1e-3;

// `light` from p (grid space); `index` counts the samples of `seed` over time.
fn sample_light(light: Light, p: vec3<f32>, seed: u32, index: u32) -> LightSample {
    if light.kind == LIGHT_DIRECTIONAL { return LightSample(-light.vector, 1e6, 1.0); }
    let v = light.vector - p;
    if AREAS && light.kind == LIGHT_SPHERE { return sample_sphere(v, light.extent, light_place(seed, index)); }
    if AREAS && light.kind >= LIGHT_RECTANGLE { return sample_rectangle(light, v, light_place(seed, index)); }
    let reach = length(v);
    let direction = v / max(reach, 1e-6);
    let metres = max(reach * frame.voxel_size, 1e-3);
    let share = reach * reach * light.extent;
    let window = max(1.0 - share * share, 0.0);
    var strength = window * window / (metres * metres);
    if light.kind == LIGHT_SPOT {
        let cone = saturate(-dot(light.axis_u, direction) * light.cone_scale + light.cone_offset);
        strength *= cone * cone;
    }
    return LightSample(direction, reach, strength);
}

// About what a light can bring to a brick, unshadowed, `middle` being its middle (grid space); 0 only where it brings
// nothing.
fn light_bound(light: Light, middle: vec3<f32>) -> f32 {
    let power = brightness(light.color);
    if light.kind == LIGHT_DIRECTIONAL { return power; }
    let v = light.vector - middle;
    let distance = length(v);
    let d2 = max(distance * distance, BRICK_RADIUS * BRICK_RADIUS);
    if AREAS && light.kind == LIGHT_SPHERE { return power * 0.5 * TAU * min(light.extent * light.extent / d2, 1.0); }
    if AREAS && light.kind >= LIGHT_RECTANGLE {
        let area = cross(light.axis_u, light.axis_v);
        let is_behind = dot(v, area) > BRICK_RADIUS * length(area) && light.kind != LIGHT_TWO_SIDED_RECTANGLE;
        return select(power * min(4.0 * length(area) / d2, TAU), 0.0, is_behind);
    }
    let nearest = max(distance - BRICK_RADIUS, 0.0);
    let share = nearest * nearest * light.extent;
    let window = max(1.0 - share * share, 0.0);
    var strength = window * window / (d2 * frame.voxel_size * frame.voxel_size);
    if light.kind == LIGHT_SPOT && distance > BRICK_RADIUS {
        // The brick's point that is nearest to the axis.
        let sine = BRICK_RADIUS / distance;
        let cosine = sqrt(1.0 - sine * sine);
        let middle_cosine = clamp(-dot(light.axis_u, v) / distance, -1.0, 1.0);
        let aside = sqrt(1.0 - middle_cosine * middle_cosine);
        let best = select(middle_cosine * cosine + aside * sine, 1.0, middle_cosine > cosine);
        let cone = saturate(best * light.cone_scale + light.cone_offset);
        strength *= cone * cone;
    }
    return power * strength;
}

fn brightness(color: vec3<f32>) -> f32 {
    return color.x + color.y + color.z;
}

// Steps of sqrt 2 and sqrt 3, in 32-bit fixed point. Not those of `r2`, which choose the point on the face: with the same
// ones each point would see the same part of the light for ever.
fn light_place(seed: u32, index: u32) -> vec2<f32> {
    let start = vec2<u32>(pcg(seed ^ 0x51633e2du), pcg(seed ^ 0xc2b2ae35u));
    let fixed = start + vec2<u32>(0x6a09e667u, 0xbb67ae85u) * index;
    return vec2<f32>(unit_float(fixed.x), unit_float(fixed.y));
}

// A direction into the cone that a sphere fills, evenly by solid angle (Shirley, Wang and Zimmerman, Monte Carlo
// Techniques for Direct Lighting Calculations, TOG 1996). `v`: to its middle.
fn sample_sphere(v: vec3<f32>, radius: f32, u: vec2<f32>) -> LightSample {
    let distance = length(v);
    if distance <= radius { return LightSample(); }
    let sine = radius / distance;
    // 1 - cos of the cone's half angle, without cancellation.
    let cap = sine * sine / (1.0 + sqrt(1.0 - sine * sine));
    let height = u.x * cap;
    let aside = sqrt(height * (2.0 - height));
    let phi = TAU * u.y;
    let direction = basis(v / distance) * vec3<f32>(aside * cos(phi), aside * sin(phi), 1.0 - height);
    let half_chord = sqrt(max(radius * radius - distance * distance * aside * aside, 0.0));
    return LightSample(direction, distance * (1.0 - height) - half_chord, TAU * cap);
}

// A direction to a rectangle, evenly by solid angle (Urena, Fajardo and King, An Area-Preserving Parametrization for
// Spherical Rectangles, EGSR 2013; angles are added as complex numbers, so that no arc cosine is rounded). `v`: to its
// middle.
fn sample_rectangle(light: Light, v: vec3<f32>, u: vec2<f32>) -> LightSample {
    let half = vec2<f32>(length(light.axis_u), length(light.axis_v));
    let x = light.axis_u / half.x;
    let y = light.axis_v / half.y;
    let middle = vec3<f32>(dot(v, x), dot(v, y), dot(v, cross(x, y)));
    if middle.z > 0.0 && light.kind != LIGHT_TWO_SIDED_RECTANGLE { return LightSample(); }
    let h = max(abs(middle.z), 1e-6);
    let low = middle.xy - half;
    let high = middle.xy + half;
    let angle = rectangle_angle(low, high, h);
    var place = middle.xy + half * (2.0 * u - 1.0);
    var strength = angle;
    if angle < SMALL_ANGLE {
        let d2 = dot(place, place) + h * h;
        strength = 4.0 * half.x * half.y * h / (d2 * sqrt(d2));
    } else {
        place = spherical_place(low, high, h, angle, u);
    }
    let to = x * place.x + y * place.y + (v - x * middle.x - y * middle.y);
    let reach = length(to);
    return LightSample(to / reach, reach, strength);
}

// Solid angle of a rectangle in the plane at height h (van Oosterom and Strackee, The Solid Angle of a Plane Triangle,
// 1983): two triangles.
fn rectangle_angle(low: vec2<f32>, high: vec2<f32>, h: f32) -> f32 {
    let a = vec3<f32>(low, h);
    let b = vec3<f32>(high.x, low.y, h);
    let c = vec3<f32>(high, h);
    let d = vec3<f32>(low.x, high.y, h);
    // Of both: the product of their edges.
    let volume = (high.x - low.x) * (high.y - low.y) * h;
    return triangle_angle(a, b, c, volume) + triangle_angle(a, c, d, volume);
}

fn triangle_angle(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, volume: f32) -> f32 {
    let l = vec3<f32>(length(a), length(b), length(c));
    return 2.0 * atan2(volume, l.x * l.y * l.z + dot(a, b) * l.z + dot(a, c) * l.y + dot(b, c) * l.x);
}

// A place in the rectangle's plane, evenly by solid angle. Names are the paper's.
fn spherical_place(low: vec2<f32>, high: vec2<f32>, h: f32, angle: f32, u: vec2<f32>) -> vec2<f32> {
    // z of the normals of the planes through the edges.
    let b0 = -low.y / length(vec2<f32>(low.y, h));
    let b1 = high.y / length(vec2<f32>(high.y, h));
    let n3 = -low.x / length(vec2<f32>(low.x, h));
    // e^(i au), au = u S - g2 - g3.
    let corners = turn(turned_back(-b1 * n3), turned_back(-n3 * b0));
    let au = turn(corners, vec2<f32>(cos(u.x * angle), sin(u.x * angle)));
    let sine = select(-1.0, 1.0, au.y >= 0.0) * max(abs(au.y), 1e-7);
    let fu = (au.x * b0 - b1) / sine;
    let cu = select(-1.0, 1.0, fu > 0.0) * min(inverseSqrt(fu * fu + b0 * b0), 1.0);
    let x = clamp(cu * h * inverseSqrt(max(1.0 - cu * cu, 1e-12)), low.x, high.x);
    let d2 = x * x + h * h;
    let h0 = low.y * inverseSqrt(d2 + low.y * low.y);
    let h1 = high.y * inverseSqrt(d2 + high.y * high.y);
    let hv = mix(h0, h1, u.y);
    let y = clamp(hv * sqrt(d2 / max(1.0 - hv * hv, 1e-12)), low.y, high.y);
    return vec2<f32>(x, y);
}

// e^(-i g) of the angle 0 to pi with that cosine.
fn turned_back(cosine: f32) -> vec2<f32> {
    return vec2<f32>(cosine, -sqrt(max(1.0 - cosine * cosine, 0.0)));
}

// Product of complex numbers.
fn turn(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
