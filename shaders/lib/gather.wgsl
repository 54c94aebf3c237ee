// What the screen probes around a pixel say of its irradiance. Whoever imports this declares `probes`.

#import lib/probes.wgsl

@res var<storage, read> probe_irradiance: array<vec4<f32>>;

// With which probes stand for a pixel.
const LEAST_WEIGHT: f32 = 1e-3;
// Weight of one that stands far off on the same plane.
const FAR_WEIGHT: f32 = 0.004;

// What the probes around a pixel say.
struct Gathered {
    // Of weighted irradiance and the share of directions it was seen in.
    sum: vec4<f32>,
    weight: f32,
    // One of the probes, drawn in proportion to its weight.
    guide: u32,
}

// The probes of the four tiles around a pixel, of both layers, weighted by distance on screen, plane distance and normal;
// where none of them stands for it, those of more and more tiles. `draw`: evenly in [0, 1).
fn gather_probes(pixel: vec2<u32>, surface: Surface, draw: f32) -> Gathered {
    let distance = length(surface.position);
    var gathered = Gathered();
    var rest = draw;
    for (var k = 0u; k < 4u * PROBE_LAYERS; k++) {
        let index = probe_around(pixel, k);
        let weight = probe_weight(pixel, surface, distance, index);
        // It may underflow.
        if weight <= 0.0 { continue; }
        gathered.sum += probe_normal_irradiance(index, probes[index * 2u + 1u].xyz, surface.normal) * weight;
        gathered.weight += weight;
        // Reservoir of one: what is left of the draw serves the next.
        let share = weight / gathered.weight;
        if rest < share {
            gathered.guide = index;
            rest /= share;
        } else {
            rest = (rest - share) / (1.0 - share);
        }
    }
    for (var level = 1u; level <= PROBE_MIPS && gathered.weight <= LEAST_WEIGHT; level++) {
        gathered = gather_mip(pixel, surface, level, draw);
    }
    return gathered;
}

// As above, of what a level of mips names around the pixel.
fn gather_mip(pixel: vec2<u32>, surface: Surface, level: u32, draw: f32) -> Gathered {
    let corner = floor((vec2<f32>(pixel) + 0.5) / f32(view.tile_size << level) - 0.5);
    let distance = length(surface.position);
    let cells = mip_cells(level);
    let start = mip_start(level);
    var gathered = Gathered();
    for (var k = 0u; k < 4u; k++) {
        let offset = vec2<i32>(vec2<u32>(k & 1u, k >> 1u));
        let cell = vec2<u32>(clamp(vec2<i32>(corner) + offset, vec2<i32>(0), vec2<i32>(cells) - 1));
        let named = vec4<u32>(probes[start + cell.y * cells.x + cell.x]);
        for (var quarter = 0u; quarter < 4u; quarter++) {
            if named[quarter] == 0u { continue; }
            let index = named[quarter] - 1u;
            let normal = probes[index * 2u + 1u].xyz;
            let weight = FAR_WEIGHT * likeness(surface, Surface(true, probes[index * 2u].xyz, normal), distance);
            if weight <= 0.0 { continue; }
            gathered.sum += probe_normal_irradiance(index, normal, surface.normal) * weight;
            gathered.weight += weight;
            if fract(draw + 0.618034 * f32(4u * k + quarter)) * gathered.weight <= weight { gathered.guide = index; }
        }
    }
    return gathered;
}

// Place of one of the probes of the four tiles around a pixel, layer by layer.
fn probe_around(pixel: vec2<u32>, k: u32) -> u32 {
    let corner = floor((vec2<f32>(pixel) + 0.5) / f32(view.tile_size) - 0.5);
    let offset = vec2<i32>(vec2<u32>(k & 1u, (k >> 1u) & 1u));
    let tile = vec2<u32>(clamp(vec2<i32>(corner) + offset, vec2<i32>(0), vec2<i32>(view.tiles) - 1));
    return probe_index(tile, k >> 2u);
}

// How far a probe stands for a pixel's surface, `distance` from the camera; 0: it does not, or there is none.
fn probe_weight(pixel: vec2<u32>, surface: Surface, distance: f32, index: u32) -> f32 {
    let probe = probes[index * 2u];
    if u32(probe.w) == PROBE_NONE { return 0.0; }
    let facet = probes[index * 2u + 1u];
    let bits = bitcast<u32>(facet.w);
    let apart = (vec2<f32>(pixel) - vec2<f32>(vec2<u32>(bits & 0xffffu, bits >> 16u))) / (0.3 * f32(view.tile_size));
    let near = exp2(-dot(apart, apart)) + FAR_WEIGHT;
    return near * likeness(surface, Surface(true, probe.xyz, facet.xyz), distance);
}

// Bilinear look-up in a probe's 3 x 3 irradiance map.
fn probe_normal_irradiance(index: u32, probe_normal: vec3<f32>, normal: vec3<f32>) -> vec4<f32> {
    let square = hemi_square(normal * basis(probe_normal));
    let place = clamp((square - 0.25) * 4.0, vec2<f32>(0.0), vec2<f32>(2.0));
    let corner = min(vec2<u32>(place), vec2<u32>(1u));
    let part = place - vec2<f32>(corner);
    let first = index * 9u + corner.y * 3u + corner.x;
    let low = mix(probe_irradiance[first], probe_irradiance[first + 1u], part.x);
    let high = mix(probe_irradiance[first + 3u], probe_irradiance[first + 4u], part.x);
    return mix(low, high, part.y);
}
